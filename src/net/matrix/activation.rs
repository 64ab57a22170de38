//! Activation functions of the network, on SIMD registers.

use pulp::Simd;

/// Activation function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Act {
    /// Identity.
    None,
    /// Gated linear unit with an algebraic sigmoid, `z (1 + z / sqrt(1 + z2)) / 2`.
    Gated,
}

/// Computes `act(z)`.
#[inline(always)]
pub fn activate<S: Simd>(simd: S, act: Act, z: S::f32s) -> S::f32s {
    match act {
        Act::None => z,
        Act::Gated => gated(simd, z),
    }
}

/// Computes `z (1 + z / sqrt(1 + z2)) / 2`, to a few units in the last place.
#[inline(always)]
pub fn gated<S: Simd>(simd: S, z: S::f32s) -> S::f32s {
    let square = simd.mul_add_e_f32s(z, z, simd.splat_f32s(1.0));
    let half = simd.mul_f32s(z, simd.splat_f32s(0.5));
    let gate = simd.mul_f32s(z, inverse_root(simd, square));
    simd.mul_add_e_f32s(half, gate, half)
}

/// Computes `(z + sqrt(z2 + 1)) / 2`, without cancellation for z << 0.
#[inline(always)]
pub fn squareplus<S: Simd>(simd: S, z: S::f32s) -> S::f32s {
    let root = simd.sqrt_f32s(simd.mul_add_e_f32s(z, z, simd.splat_f32s(1.0)));
    let sum = simd.mul_f32s(simd.add_f32s(root, simd.abs_f32s(z)), simd.splat_f32s(0.5));
    let negative = simd.less_than_f32s(z, simd.splat_f32s(0.0));
    simd.select_f32s(negative, simd.div_f32s(simd.splat_f32s(0.25), sum), sum)
}

/// Computes `1 / sqrt(x)` for normal x > 0: an estimate from the exponent bits (Lomont 2003), then one step of Halley's
/// method (third order) and one of Newton's. The processor's division and square root share one execution unit, which
/// would take longer than all other work of a message.
#[inline(always)]
fn inverse_root<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let bits = simd.wrapping_dyn_shr_u32s(simd.transmute_u32s_f32s(x), simd.splat_u32s(1));
    let y = simd.transmute_f32s_u32s(simd.sub_u32s(simd.splat_u32s(0x5f37_5a86), bits));
    let t = simd.mul_f32s(simd.mul_f32s(x, y), y);
    let inner = simd.mul_add_e_f32s(t, simd.splat_f32s(0.375), simd.splat_f32s(-1.25));
    let y = simd.mul_f32s(y, simd.mul_add_e_f32s(inner, t, simd.splat_f32s(1.875)));
    let t = simd.mul_f32s(simd.mul_f32s(x, y), y);
    simd.mul_f32s(y, simd.mul_add_e_f32s(t, simd.splat_f32s(-0.5), simd.splat_f32s(1.5)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct Both<'a>(&'a [f32], &'a mut [f32], &'a mut [f32]);

    impl WithSimd for Both<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let (z, a, b) = (S::as_simd_f32s(self.0).0, S::as_mut_simd_f32s(self.1).0, S::as_mut_simd_f32s(self.2).0);
            for i in 0..z.len() {
                (a[i], b[i]) = (gated(simd, z[i]), squareplus(simd, z[i]));
            }
        }
    }

    #[test]
    fn registers_hold_what_the_formulas_say() {
        let z: Vec<f32> = (-800..800).map(|i| (i as f32 * 0.01).sinh()).collect();
        let (mut a, mut b) = (vec![0.0; z.len()], vec![0.0; z.len()]);
        Arch::new().dispatch(Both(&z, &mut a, &mut b));
        for ((z, a), b) in z.iter().zip(a).zip(b) {
            let z = f64::from(*z);
            let root = (1.0 + z * z).sqrt();
            let [gated, squareplus] = [0.5 * z * (1.0 + z / root), 0.5 * (z + root)];
            // For z << 0 the gate cancels, so the error is absolute, a fraction of |z|.
            assert!((f64::from(a) - gated).abs() < 2e-7 * (1.0 + z.abs()), "gated({z}) = {a}, not {gated}");
            assert!((f64::from(b) - squareplus).abs() < 5e-7 * squareplus, "positive({z}) = {b}, not {squareplus}");
        }
    }
}
