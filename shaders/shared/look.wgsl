// Colours and materials of what a tree carries. Twin: src/tree/organs/look.rs.
#include "shared/gloss.wgsl"

// Every look that the tree has; the first is bark.
@group(1) @binding(2) var<storage, read> looks: array<Look>;
