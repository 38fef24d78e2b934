//! Systems of the literature that stand for parametric, context-free and context-sensitive grammars.

const HONDA: &str = include_str!("../../../assets/grammars/honda.lsys");
const ROW: &str = "const p = 0.3, q = 0.7, h = (0.3*0.7)^0.5\naxiom F(1,0)\n\
    F(x,t) : t==0 -> F(x*p,2)+F(x*h,1)--F(x*h,1)+F(x*q,0)\nF(x,t) : t>0 -> F(x,t-1)\n";
const ALGAE: &str = "axiom b\na -> ab\nb -> a\n";
const HOGEWEG_HESPER: &str = "ignore +-F\naxiom F1F1F1\n0 < 0 > 0 -> 1\n0 < 0 > 1 -> 1[-F1F1]\n0 < 1 > 0 -> 1\n\
    0 < 1 > 1 -> 1\n1 < 0 > 0 -> 0\n1 < 0 > 1 -> 1F1\n1 < 1 > 0 -> 1\n1 < 1 > 1 -> 0\n+ -> -\n- -> +\n";
const BUSH: &str = "axiom A\nA -> [&FL!A]/////'[&FL!A]///////'[&FL!A]\nF -> S/////F\nS -> FL\n\
    L -> ['''^^{-f+f+f-|-f+f+f}]\n";
const STOCH: &str = "axiom F\nF : weight 0.33 -> F[+F]F[-F]F\nF : weight 0.33 -> F[+F]F\nF : weight 0.34 -> F[-F]F\n";

/// A system to time.
pub(crate) struct System {
    /// Its name.
    pub(crate) name: &'static str,
    /// Its text.
    pub(crate) grammar: String,
    /// Steps.
    pub(crate) steps: u32,
    /// Modules of the last string; none where it is random.
    pub(crate) length: Option<usize>,
}

/// All of them.
pub(crate) fn systems() -> Vec<System> {
    let system = |name, grammar: &str, steps, length| System {
        name,
        grammar: grammar.to_owned(),
        steps,
        length,
    };
    let signal = format!("axiom b{}\nb < a -> b\nb -> a\n", "a".repeat(1 << 20));
    let diffuse = format!(
        "axiom {}\nC(l) < C(x) > C(r) : x>=0 -> C(x+0.25*(l+r-2*x))\n",
        cells()
    );
    vec![
        system("algae", ALGAE, 35, Some(14_930_352)),
        system("bush", BUSH, 11, Some(6_351_974)),
        system("stoch", STOCH, 11, None),
        system("honda", HONDA, 18, Some(1_835_002)),
        system("row", ROW, 18, Some(3_530_486)),
        system("signal", &signal, 20, Some(1_048_577)),
        system("hh", HOGEWEG_HESPER, 36, Some(141_946)),
        system("diffuse", &diffuse, 10, Some(131_072)),
    ]
}

/// The axiom of the diffusion.
pub(crate) fn cells() -> String {
    (0..1_u32 << 17)
        .map(|i| format!("C({})", i.count_ones()))
        .collect()
}
