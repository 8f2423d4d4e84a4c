//! The basis functions and sums over points, in lanes.
//!
//! Y_l,±m = Q_l,m(z) · (Re, Im)(x + iy)^m, where Q_l,m is the normalized associated Legendre function without its
//! factor sinᵐθ. Taken so, everything is a polynomial of x, y and z: there is no angle, and no special case
//! at the poles. Q_m,m = √(binomial(2m, m)/4ᵐ · (2m+1)/4π) stays near 1 at any order, and
//!
//! Q_l,m = a z Q_l-1,m - b Q_l-2,m, with a² = (4l² - 1)/(l² - m²) and b² = a² ((l-1)² - m²)/(4(l-1)² - 1),
//!
//! is stable upward in l (Holmes & Featherstone 2002): 2e-13 at order 64.
//!
//! Sums over points take two degrees at a time: the loads of the values then serve 2 × 2 × channels sums, and
//! arithmetic is what limits.

use super::count::count;
use crate::kernel;
use crate::kernel::SimdWork;
use crate::light::patches::{LANES, add_lanes};
use crate::number::real::Real;
use fearless_simd::{Simd, SimdBase, f64x8};
use std::f64::consts::PI;

type Lanes = [f64; LANES];

/// Points with weights, as rows of numbers.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Components of unit directions.
    pub x: Vec<f64>,
    /// The second.
    pub y: Vec<f64>,
    /// The third.
    pub z: Vec<f64>,
    /// Weights.
    pub weight: Vec<f64>,
    used: usize,
}

impl Points {
    /// Adds one.
    pub fn push(&mut self, d: [f64; 3], weight: f64) {
        self.x.push(d[0]);
        self.y.push(d[1]);
        self.z.push(d[2]);
        self.weight.push(weight);
        self.used += 1;
    }

    /// Fills up to whole lanes with points of weight 0.
    pub fn fill_up(&mut self) {
        let n = self.used.next_multiple_of(LANES);
        for row in [&mut self.x, &mut self.y, &mut self.z, &mut self.weight] {
            row.resize(n, 0.0);
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.used
    }

    /// One of them.
    pub fn direction(&self, k: usize) -> [f64; 3] {
        [self.x[k], self.y[k], self.z[k]]
    }
}

/// The constants of the recurrence up to an order.
#[derive(Clone, Debug)]
pub struct Basis {
    order: usize,
    /// Q_m,m, with the √2 of m > 0.
    first: Vec<f64>,
    /// (a, b) of the step to degree l + 2 at place l - m of row m.
    steps: Vec<Vec<(f64, f64)>>,
}

impl Basis {
    /// Up to this order.
    pub fn new(order: usize) -> Basis {
        let mut first = vec![(0.25 / PI).sqrt()];
        for m in 1..=order {
            let (x, root) = (m as f64, if m == 1 { 2.0 } else { 1.0 });
            first.push(first[m - 1] * (root * (2.0 * x + 1.0) / (2.0 * x)).sqrt());
        }
        // Rows go on to three degrees above the order: sums take two at a time.
        let row = |m: usize| {
            let step = |l: usize| {
                let (m2, l2) = ((m * m) as f64, (l * l) as f64);
                let k2 = ((l - 1) * (l - 1)) as f64;
                let a = ((4.0 * l2 - 1.0) / (l2 - m2)).sqrt();
                let b = if l > m + 1 {
                    a * ((k2 - m2) / (4.0 * k2 - 1.0)).sqrt()
                } else {
                    0.0
                };
                (a, b)
            };
            (m + 1..=order + 4).map(step).collect()
        };
        Basis {
            order,
            first,
            steps: (0..=order).map(row).collect(),
        }
    }

    /// Adds Σ value · Y of `N` rows of values to `sums`: `N` lanes a coefficient.
    pub fn analyze<const N: usize>(
        &self,
        points: [&[f64]; 3],
        rows: [&[f64]; N],
        scratch: &mut Scratch,
        sums: &mut [Lanes],
    ) {
        scratch.fit(points[0].len() / LANES, 2 * N);
        match N {
            1 => kernel::run_simd(Analyze::<N, 2> {
                basis: self,
                points,
                rows,
                scratch,
                sums,
            }),
            3 => kernel::run_simd(Analyze::<N, 6> {
                basis: self,
                points,
                rows,
                scratch,
                sums,
            }),
            _ => {}
        }
    }

    /// Adds the sums over rings of one m: `values` are 2 · channels rows over the rings, cosine parts first.
    pub fn legendre<const M: usize>(
        &self,
        m: usize,
        z: &[f64],
        values: [&[f64]; M],
        scratch: &mut Scratch,
        sums: &mut [Lanes],
    ) {
        scratch.fit(z.len() / LANES, M);
        kernel::run_simd(Legendre {
            basis: self,
            m,
            z: z.as_chunks().0,
            values,
            scratch,
            sums,
        });
    }

    /// Σ coefficient · Y at a unit direction, in the order of [`Basis::synthesize`]: on numbers that record, its graph.
    /// Coefficients that are 0 say nothing.
    pub fn at<R: Real>(&self, coefficients: &[f64], [x, y, z]: [R; 3]) -> R {
        // What is nothing yet is not added: the sums begin with their first term.
        let add = |sum: Option<R>, term: R| Some(sum.map_or(term, |sum| sum + term));
        let with = |sum: Option<R>, coefficient: f64, value: R| {
            if coefficient == 0.0 {
                sum
            } else {
                add(sum, value * R::new(coefficient))
            }
        };
        let (mut re, mut im) = (R::ONE, R::ZERO);
        let mut sum = None;
        for m in 0..=self.order {
            (re, im) = match m {
                0 => (re, im),
                1 => (x, y),
                _ => (re * x - im * y, re * y + im * x),
            };
            let (mut low, mut before) = (R::new(self.first[m]), R::ZERO);
            let (mut plus, mut minus) = (None, None);
            for l in m..=self.order {
                let place = l * l + l;
                plus = with(plus, coefficients[place + m], low);
                if m > 0 {
                    minus = with(minus, coefficients[place - m], low);
                }
                let (a, b) = self.steps[m][l - m];
                let next = R::new(a) * z * low - R::new(b) * before;
                (before, low) = (low, next);
            }
            let parts = [plus.map(|plus| re * plus), minus.map(|minus| im * minus)];
            let both = parts.into_iter().flatten().reduce(|a, b| a + b);
            sum = both.map_or(sum, |both| add(sum, both));
        }
        sum.unwrap_or(R::ZERO)
    }

    /// Σ coefficient · Y at each point: `channels` numbers a point, for the points that are in use.
    pub fn synthesize(
        &self,
        points: &Points,
        coefficients: &[f64],
        channels: usize,
        out: &mut [f64],
    ) {
        let used = points.used;
        let mut rows = vec![[0.0; LANES]; points.x.len() / LANES];
        for channel in 0..channels {
            let own: Vec<f64> = coefficients[channel..]
                .iter()
                .step_by(channels)
                .copied()
                .collect();
            kernel::run_simd(Synthesize {
                basis: self,
                points: [&points.x, &points.y, &points.z],
                coefficients: &own,
                out: &mut rows,
            });
            for (k, value) in rows.as_flattened()[..used].iter().enumerate() {
                out[k * channels + channel] = *value;
            }
        }
    }
}

/// Room for one block of points.
#[derive(Default)]
pub struct Scratch {
    powers: [Vec<Lanes>; 2],
    products: Vec<Vec<Lanes>>,
    degrees: [Vec<Lanes>; 2],
}

impl Scratch {
    fn fit(&mut self, n: usize, products: usize) {
        let zero = [0.0; LANES];
        self.products
            .resize(products.max(self.products.len()), Vec::new());
        let all = self.powers.iter_mut().chain(&mut self.degrees);
        for row in all.chain(&mut self.products) {
            row.resize(n, zero);
        }
    }
}

struct Analyze<'a, const N: usize, const M: usize> {
    basis: &'a Basis,
    points: [&'a [f64]; 3],
    rows: [&'a [f64]; N],
    scratch: &'a mut Scratch,
    sums: &'a mut [Lanes],
}

impl<const N: usize, const M: usize> SimdWork for Analyze<'_, N, M> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let [x, y, z] = self.points.map(|p| p.as_chunks::<LANES>().0);
        let n = x.len();
        let rows = self.rows.map(|r| &r.as_chunks::<LANES>().0[..n]);
        let Scratch {
            powers: [real, imaginary],
            products,
            degrees: [p, q],
        } = self.scratch;
        let (y, z) = (&y[..n], &z[..n]);
        let (real, imaginary) = (&mut real[..n], &mut imaginary[..n]);
        for m in 0..=self.basis.order {
            for i in 0..n {
                let (re, im) = if m == 0 {
                    (f64x8::splat(simd, 1.0), f64x8::splat(simd, 0.0))
                } else {
                    let (re, im) = (load(simd, &real[i]), load(simd, &imaginary[i]));
                    let (x, y) = (load(simd, &x[i]), load(simd, &y[i]));
                    (re * x - im * y, re * y + im * x)
                };
                re.store_array(&mut real[i]);
                im.store_array(&mut imaginary[i]);
                for k in 0..N {
                    let value = load(simd, &rows[k][i]);
                    (value * re).store_array(&mut products[k][i]);
                    (value * im).store_array(&mut products[N + k][i]);
                }
            }
            let values: [&[Lanes]; M] = std::array::from_fn(|k| &products[k][..n]);
            degrees::<S, M>(
                simd,
                self.basis,
                m,
                z,
                values,
                [&mut p[..n], &mut q[..n]],
                self.sums,
            );
        }
    }
}

struct Legendre<'a, const M: usize> {
    basis: &'a Basis,
    m: usize,
    z: &'a [Lanes],
    values: [&'a [f64]; M],
    scratch: &'a mut Scratch,
    sums: &'a mut [Lanes],
}

impl<const M: usize> SimdWork for Legendre<'_, M> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let n = self.z.len();
        let values = self.values.map(|v| &v.as_chunks::<LANES>().0[..n]);
        let [p, q] = &mut self.scratch.degrees;
        let rooms = [&mut p[..n], &mut q[..n]];
        degrees::<S, M>(simd, self.basis, self.m, self.z, values, rooms, self.sums);
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, x: &Lanes) -> f64x8<S> {
    f64x8::load_array_ref(simd, x)
}

/// Adds Σ Q_l,m(z) · value for all degrees of one m. The first half of `values` belongs to +m, the
/// second to -m.
#[inline(always)]
fn degrees<S: Simd, const M: usize>(
    simd: S,
    basis: &Basis,
    m: usize,
    z: &[Lanes],
    values: [&[Lanes]; M],
    [p, q]: [&mut [Lanes]; 2],
    sums: &mut [Lanes],
) {
    let n = z.len();
    let steps = &basis.steps[m];
    let first = f64x8::splat(simd, basis.first[m]);
    let second = f64x8::splat(simd, steps[0].0);
    for i in 0..n {
        first.store_array(&mut p[i]);
        (second * load(simd, &z[i]) * first).store_array(&mut q[i]);
    }
    let mut l = m;
    while l <= basis.order {
        let [(a, b), (c, d)] = [steps[l - m + 1], steps[l - m + 2]];
        let [a, b, c, d] = [a, b, c, d].map(|k| f64x8::splat(simd, k));
        let zero = f64x8::splat(simd, 0.0);
        let (mut even, mut odd) = ([zero; M], [zero; M]);
        for i in 0..n {
            let (z, low, high) = (load(simd, &z[i]), load(simd, &p[i]), load(simd, &q[i]));
            for k in 0..M {
                let value = load(simd, &values[k][i]);
                even[k] += low * value;
                odd[k] += high * value;
            }
            let low = a * z * high - b * low;
            let high = c * z * low - d * high;
            low.store_array(&mut p[i]);
            high.store_array(&mut q[i]);
        }
        add::<S, M>(simd, m, l, even, sums);
        if l < basis.order {
            add::<S, M>(simd, m, l + 1, odd, sums);
        }
        l += 2;
    }
}

#[inline(always)]
fn add<S: Simd, const M: usize>(
    simd: S,
    m: usize,
    l: usize,
    values: [f64x8<S>; M],
    sums: &mut [Lanes],
) {
    let half = M / 2;
    for k in 0..half {
        let plus = &mut sums[(l * l + l + m) * half + k];
        (load(simd, plus) + values[k]).store_array(plus);
        if m > 0 {
            let minus = &mut sums[(l * l + l - m) * half + k];
            (load(simd, minus) + values[half + k]).store_array(minus);
        }
    }
}

struct Synthesize<'a> {
    basis: &'a Basis,
    points: [&'a [f64]; 3],
    coefficients: &'a [f64],
    out: &'a mut [Lanes],
}

impl SimdWork for Synthesize<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        // Vectors side by side hide the latency of the recurrence.
        const SIDE: usize = 4;
        let [x, y, z] = self.points.map(|p| p.as_chunks::<LANES>().0);
        let n = x.len();
        let (y, z) = (&y[..n], &z[..n]);
        let zero = f64x8::splat(simd, 0.0);
        let mut start = 0;
        while start < n {
            // The last group overlaps the one before it, or repeats its last vector.
            let at: [usize; SIDE] = std::array::from_fn(|k| (start + k).min(n - 1));
            let [x, y, z] = [x, y, z].map(|row| at.map(|i| load(simd, &row[i])));
            let mut re = [f64x8::splat(simd, 1.0); SIDE];
            let mut im = [zero; SIDE];
            let mut sum = [zero; SIDE];
            for m in 0..=self.basis.order {
                if m > 0 {
                    for k in 0..SIDE {
                        let r = re[k] * x[k] - im[k] * y[k];
                        im[k] = re[k] * y[k] + im[k] * x[k];
                        re[k] = r;
                    }
                }
                let mut low = [f64x8::splat(simd, self.basis.first[m]); SIDE];
                let mut before = [zero; SIDE];
                let (mut plus, mut minus) = ([zero; SIDE], [zero; SIDE]);
                for l in m..=self.basis.order {
                    let place = l * l + l;
                    let [c, d] = [
                        self.coefficients[place + m],
                        if m > 0 {
                            self.coefficients[place - m]
                        } else {
                            0.0
                        },
                    ]
                    .map(|c| f64x8::splat(simd, c));
                    let (a, b) = self.basis.steps[m][l - m];
                    let [a, b] = [a, b].map(|c| f64x8::splat(simd, c));
                    for k in 0..SIDE {
                        plus[k] += low[k] * c;
                        minus[k] += low[k] * d;
                        let next = a * z[k] * low[k] - b * before[k];
                        before[k] = low[k];
                        low[k] = next;
                    }
                }
                for k in 0..SIDE {
                    sum[k] += re[k] * plus[k] + im[k] * minus[k];
                }
            }
            for k in 0..SIDE {
                sum[k].store_array(&mut self.out[at[k]]);
            }
            start += SIDE;
        }
    }
}

/// Σ weight · value · Y over points: `channels` values a point, (order + 1)² rows of as many sums.
pub fn analyze_points(points: &Points, values: &[f64], channels: usize, order: usize) -> Vec<f64> {
    let basis = Basis::new(order);
    let n = points.x.len();
    let rows: Vec<Vec<f64>> = (0..channels)
        .map(|c| {
            let mut row = vec![0.0; n];
            for (k, value) in values[c..].iter().step_by(channels).enumerate() {
                row[k] = value * points.weight[k];
            }
            row
        })
        .collect();
    // Blocks that stay in the first-level cache, taken by threads; each has its own sums.
    const BLOCK: usize = 256;
    let per = count(order) * channels;
    let groups = (n / BLOCK).clamp(1, 32);
    let group = n.div_ceil(groups).next_multiple_of(BLOCK);
    let groups = n.div_ceil(group);
    let mut parts = vec![0.0; groups * per];
    crate::kernel::threads::rows(&mut parts, per, n * (order + 1), |number, part| {
        let span = number * group..((number + 1) * group).min(n);
        let mut sums = Sums::new(order, channels);
        for start in span.clone().step_by(BLOCK) {
            let span = start..(start + BLOCK).min(span.end);
            let points = [
                &points.x[span.clone()],
                &points.y[span.clone()],
                &points.z[span.clone()],
            ];
            sums.add(&basis, points, |c| &rows[c][span.clone()]);
        }
        sums.finish(part);
    });
    add_parts(&parts, per)
}

/// The sum of rows of `per` numbers, in their order.
pub fn add_parts(parts: &[f64], per: usize) -> Vec<f64> {
    let mut total = vec![0.0; per];
    for part in parts.chunks_exact(per) {
        total.iter_mut().zip(part).for_each(|(t, p)| *t += p);
    }
    total
}

/// Sums of several channels, three or one at a time.
pub struct Sums {
    channels: usize,
    count: usize,
    scratch: Scratch,
    groups: Vec<(usize, usize, Vec<Lanes>)>,
}

impl Sums {
    /// All zero.
    pub fn new(order: usize, channels: usize) -> Sums {
        let count = count(order);
        let mut groups = Vec::new();
        let mut first = 0;
        while first < channels {
            let size = if channels - first >= 3 { 3 } else { 1 };
            groups.push((first, size, vec![[0.0; LANES]; count * size]));
            first += size;
        }
        Sums {
            channels,
            count,
            scratch: Scratch::default(),
            groups,
        }
    }

    /// Adds a block of points; `row` gives the values of a channel.
    pub fn add<'a>(
        &mut self,
        basis: &Basis,
        points: [&[f64]; 3],
        row: impl Fn(usize) -> &'a [f64],
    ) {
        let scratch = &mut self.scratch;
        for (first, size, sums) in &mut self.groups {
            if *size == 3 {
                let rows = [row(*first), row(*first + 1), row(*first + 2)];
                basis.analyze::<3>(points, rows, scratch, sums);
            } else {
                basis.analyze::<1>(points, [row(*first)], scratch, sums);
            }
        }
    }

    /// Adds the rings of one m; `row` gives the cosine and sine parts of a channel.
    pub fn add_rings<'a>(
        &mut self,
        basis: &Basis,
        m: usize,
        z: &[f64],
        row: impl Fn(usize) -> [&'a [f64]; 2],
    ) {
        let scratch = &mut self.scratch;
        for (first, size, sums) in &mut self.groups {
            let [a, d] = row(*first);
            if *size == 3 {
                let ([b, e], [c, f]) = (row(*first + 1), row(*first + 2));
                basis.legendre::<6>(m, z, [a, b, c, d, e, f], scratch, sums);
            } else {
                basis.legendre::<2>(m, z, [a, d], scratch, sums);
            }
        }
    }

    /// The sums: one number a channel for each coefficient.
    pub fn finish(&self, out: &mut [f64]) {
        for (first, size, sums) in &self.groups {
            for coefficient in 0..self.count {
                for k in 0..*size {
                    out[coefficient * self.channels + first + k] =
                        add_lanes(&sums[coefficient * size + k]);
                }
            }
        }
    }
}
