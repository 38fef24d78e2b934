// Runs one system in npm's `lindenmayer`: node lindenmayer.cjs MODULES NAME STEPS; prints CPU seconds and modules.
// The Hogeweg–Hesper plant is left out: its contexts take a time that grows with the square of the string.
const path = require("node:path");
const LSystem = require(path.join(process.argv[2], "lindenmayer"));
const [name, steps] = [process.argv[3], Number(process.argv[4])];

const F = (...params) => ({ symbol: "F", params });
const c = { r1: 0.9, r2: 0.6, wr: 0.707, h: Math.sqrt(0.21) };
const m = (symbol, ...params) => ({ symbol, params });
const limb = (sign, angle, next, last) => ({ params: [l, w] }) => [
  m("!", w), m("F", l), m("["), m(sign, angle), m(next === "B" && sign === "&" ? "'" : "$"),
  m(next, l * c.r2, w * c.wr), m("]"), ...last, m(next, l * c.r1, w * c.wr),
];
const systems = {
  algae: { axiom: "b", productions: { a: "ab", b: "a" } },
  bush: {
    axiom: "A",
    productions: {
      A: "[&FL!A]/////'[&FL!A]///////'[&FL!A]", F: "S/////F", S: "FL", L: "['''^^{-f+f+f-|-f+f+f}]",
    },
  },
  stoch: {
    axiom: "F",
    productions: {
      F: {
        successors: [
          { weight: 33, successor: "F[+F]F[-F]F" },
          { weight: 33, successor: "F[+F]F" },
          { weight: 34, successor: "F[-F]F" },
        ],
      },
    },
  },
  honda: {
    axiom: [m("A", 1, 10)],
    productions: {
      A: ({ params: [l, w] }) => [
        m("!", w), m("F", l), m("["), m("&", 45), m("B", l * c.r2, w * c.wr), m("]"), m("/", 137.5),
        m("A", l * c.r1, w * c.wr),
      ],
      B: limb("-", 45, "C", []),
      C: limb("+", 45, "B", []),
    },
  },
  row: {
    axiom: [F(1, 0)],
    productions: {
      F: ({ params: [x, t] }) =>
        t > 0
          ? [F(x, t - 1)]
          : [F(x * 0.3, 2), m("+"), F(x * c.h, 1), m("-"), m("-"), F(x * c.h, 1), m("+"), F(x * 0.7, 0)],
    },
  },
  signal: { axiom: "b" + "a".repeat(1 << 20), productions: { "b<a": "b", b: "a" } },
};
if (name in systems) {
  const system = new LSystem(systems[name]);
  const start = process.cpuUsage();
  const result = system.iterate(steps);
  const { user, system: kernel } = process.cpuUsage(start);
  console.log((user + kernel) / 1e6, result.length);
}
