//! One-dimensional root and minimum searches: deterministic, with bounded iterations, without allocation.

/// Smaller part of the golden section of 1.
pub const GOLDEN: f64 = 0.381_966_011_250_105;

/// Root of `f` in [`a`, `b`] by the Illinois variant of false position, safeguarded by bisection; `f(a)` and
/// `f(b)` must differ in sign. Stops when the bracket is shorter than `tolerance`.
pub fn root(mut f: impl FnMut(f64) -> f64, mut a: f64, mut b: f64, tolerance: f64) -> f64 {
    let mut fa = f(a);
    if fa == 0.0 {
        return a;
    }
    let mut fb = f(b);
    for step in 0..80 {
        if (b - a).abs() <= tolerance || fb == 0.0 {
            break;
        }
        let mut c = b - fb * (b - a) / (fb - fa);
        if step % 3 == 2 || !c.is_finite() || (c - a) * (c - b) > 0.0 {
            c = 0.5 * (a + b);
        }
        let fc = f(c);
        if fc * fb < 0.0 {
            (a, fa) = (b, fb);
        } else {
            fa *= 0.5;
        }
        (b, fb) = (c, fc);
    }
    b
}

/// Root of `f` between `a` and `b`, (argument, value) pairs of opposite sign, by secant steps from `guess`,
/// safeguarded by bisection. Stops when the next step would be shorter than `tolerance`; returns the
/// argument of the last call of `f`.
pub fn root_from(
    mut f: impl FnMut(f64) -> f64,
    a: (f64, f64),
    b: (f64, f64),
    guess: f64,
    tolerance: f64,
) -> f64 {
    let (mut low, mut high) = if a.1 < b.1 { (a, b) } else { (b, a) };
    let inside = |x: f64, low: f64, high: f64| (x - low) * (x - high) < 0.0;
    let mut x = if inside(guess, low.0, high.0) { guess } else { 0.5 * (low.0 + high.0) };
    let mut last = if (x - low.0).abs() < (x - high.0).abs() { low } else { high };
    let mut steps = (f64::INFINITY, f64::INFINITY);
    for _ in 0..60 {
        let here = (x, f(x));
        if here.1 < 0.0 {
            low = here;
        } else {
            high = here;
        }
        let mut step = -here.1 * (x - last.0) / (here.1 - last.1);
        if here.1 == 0.0 || step.abs() < tolerance || (high.0 - low.0).abs() < tolerance {
            break;
        }
        // Steps that do not shorten indicate slow convergence or a discontinuity: bisect.
        if !inside(x + step, low.0, high.0) || step.abs() > 0.5 * steps.0 {
            step = 0.5 * (low.0 + high.0) - x;
        }
        steps = (steps.1, step.abs());
        last = here;
        x += step;
    }
    x
}

/// Minimum over a full turn of `f`, which maps an angle (rad) to (value, slope), from `SAMPLES` samples. A
/// minimum between two samples is searched where one of them is at most `margin` above the lowest sample.
pub fn min_over_turn<const SAMPLES: usize>(mut f: impl FnMut(f64) -> (f64, f64), margin: f64) -> f64 {
    let step = std::f64::consts::TAU / SAMPLES as f64;
    let samples: [(f64, f64); SAMPLES] = std::array::from_fn(|i| f(step * i as f64));
    let lowest = samples.iter().map(|s| s.0).fold(f64::INFINITY, f64::min);
    let mut least = lowest;
    for i in 0..SAMPLES {
        let (a, b) = (samples[i], samples[(i + 1) % SAMPLES]);
        if a.1 >= 0.0 || b.1 <= 0.0 || a.0.min(b.0) > lowest + margin {
            continue;
        }
        let from = step * i as f64;
        least = least.min(min_between_slopes(&mut f, (from, a.1), (from + step, b.1), 1e-5));
    }
    least
}

/// Minimum of `f`, which maps an argument to (value, slope), between the (argument, slope) pairs `from`,
/// where it falls, and `to`, where it rises; by root search on the slope, to `tolerance` in the argument.
pub fn min_between_slopes(
    mut f: impl FnMut(f64) -> (f64, f64),
    from: (f64, f64),
    to: (f64, f64),
    tolerance: f64,
) -> f64 {
    let mut least = f64::INFINITY;
    let slope = |x: f64| {
        let (value, slope) = f(x);
        least = least.min(value);
        slope
    };
    let guess = from.0 + (to.0 - from.0) * from.1 / (from.1 - to.1);
    root_from(slope, from, to, guess, tolerance);
    least
}

/// Minimum of `f` in [`a`, `b`] by Brent's method, to `tolerance` in the argument. Returns (argument,
/// value). If `f` has several local minima there, one of them is found.
pub fn minimum(mut f: impl FnMut(f64) -> f64, mut a: f64, mut b: f64, tolerance: f64) -> (f64, f64) {
    let mut x = a + GOLDEN * (b - a);
    let (mut w, mut v) = (x, x);
    let mut fx = f(x);
    let (mut fw, mut fv) = (fx, fx);
    let (mut d, mut e) = (0.0f64, 0.0f64);
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        let tolerance_here = tolerance + 1e-15 * x.abs();
        if (x - middle).abs() <= 2.0 * tolerance_here - 0.5 * (b - a) {
            break;
        }
        let mut golden = true;
        if e.abs() > tolerance_here {
            let r = (x - w) * (fx - fv);
            let mut q = (x - v) * (fx - fw);
            let mut p = (x - v) * q - (x - w) * r;
            q = 2.0 * (q - r);
            if q > 0.0 {
                p = -p;
            }
            q = q.abs();
            let previous = e;
            e = d;
            if p.abs() < (0.5 * q * previous).abs() && p > q * (a - x) && p < q * (b - x) {
                d = p / q;
                let u = x + d;
                if u - a < 2.0 * tolerance_here || b - u < 2.0 * tolerance_here {
                    d = tolerance_here.copysign(middle - x);
                }
                golden = false;
            }
        }
        if golden {
            e = if x >= middle { a - x } else { b - x };
            d = GOLDEN * e;
        }
        let u = if d.abs() >= tolerance_here { x + d } else { x + tolerance_here.copysign(d) };
        let fu = f(u);
        if fu <= fx {
            if u >= x {
                a = x;
            } else {
                b = x;
            }
            (v, fv) = (w, fw);
            (w, fw) = (x, fx);
            (x, fx) = (u, fu);
        } else {
            if u < x {
                a = u;
            } else {
                b = u;
            }
            if fu <= fw || w == x {
                (v, fv) = (w, fw);
                (w, fw) = (u, fu);
            } else if fu <= fv || v == x || v == w {
                (v, fv) = (u, fu);
            }
        }
    }
    (x, fx)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_roots_and_minima_of_known_functions() {
        let r = root(|x| x * x * x - 2.0, 0.0, 2.0, 1e-12);
        assert!((r - 2f64.cbrt()).abs() < 1e-10, "cube root of 2: {r}");
        for guess in [-1.0, 0.1, 1.3, 5.0] {
            let mut calls = Vec::new();
            let f = |x: f64| x * x * x - 2.0;
            let r = root_from(
                |x| {
                    calls.push(x);
                    f(x)
                },
                (2.0, f(2.0)),
                (0.0, f(0.0)),
                guess,
                1e-6,
            );
            assert!((r - 2f64.cbrt()).abs() < 1e-6 && calls.len() < 12, "from {guess}: {r} by {calls:?}");
            assert_eq!(calls.last(), Some(&r), "the last call is the result");
        }
        let wave = |x: f64| ((2.0 * x).cos() + 0.1 * x.sin(), 0.1 * x.cos() - 2.0 * (2.0 * x).sin());
        let least = (0..100_000).map(|i| wave(1e-4 * f64::from(i)).0).fold(f64::INFINITY, f64::min);
        assert!((min_over_turn::<9>(wave, 0.1) - least).abs() < 1e-7, "two waves");
        let jump =
            root_from(|x| if x < 0.7 { -1.0 - x } else { 2.0 + x }, (0.0, -1.0), (1.0, 3.0), 0.5, 1e-6);
        assert!((jump - 0.7).abs() < 1e-6, "a jump: {jump}");
        let (x, fx) = minimum(|x| (x - 0.3).powi(2) + 1.0, -1.0, 2.0, 1e-8);
        assert!((x - 0.3).abs() < 1e-6 && (fx - 1.0).abs() < 1e-12, "parabola: {x} {fx}");
        let (x, _) = minimum(|x| x, 0.0, 1.0, 1e-9);
        assert!(x < 1e-6, "minimum at the border: {x}");
    }
}
