//! Three-vectors as arrays, in f64: what formulas of areas and edges need, in one order of operations.
//!
//! They are `const`, so that tables of vertices are made by the compiler; glam's are not.

/// Three numbers.
pub type Vec3 = [f64; 3];

/// a · b.
pub const fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a - b.
pub const fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a × b.
pub const fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// |a|.
pub fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// a brought to length 1.
pub fn normalized(a: Vec3) -> Vec3 {
    let scale = 1.0 / norm(a);
    a.map(|x| x * scale)
}
