//! Values of the elementary functions and constants, computed with mpmath.

use euler_poincare::scalar::{Dd, Real};

type Reference<T> = (&'static str, T, T, &'static str);

/// The words of a line.
fn words<const K: usize>(line: &'static str) -> [&'static str; K] {
    line.split(' ').collect::<Vec<_>>().try_into().expect("as many words")
}

/// (function, argument, second argument of atan2, 40 digits): the arguments are the nearest double-doubles to points
/// such as n/3 x 10^k and n pi/2, and the values `mpmath.nstr(f(mpf(hi) + mpf(lo)), 40)` with mp.prec = 2500.
pub fn double_double() -> impl Iterator<Item = Reference<Dd>> {
    let table = include_str!("double_double.txt");
    assert_eq!(table.lines().count(), 91);
    table.lines().map(|line| {
        let [name, x, x_low, y, y_low, value] = words(line);
        let [x, x_low, y, y_low] = [x, x_low, y, y_low].map(|part| part.parse().unwrap());
        (name, Dd::new(x, x_low), Dd::new(y, y_low), value)
    })
}

type Constant<T> = fn() -> T;

/// Constants and `mpmath.nstr(.., 70)` of them.
#[rustfmt::skip]
pub fn constants<T: Real>() -> Vec<(Constant<T>, &'static str)> {
    vec![
        (T::pi, "3.141592653589793238462643383279502884197169399375105820974944592307816"),
        (T::ln_2, "0.6931471805599453094172321214581765680755001343602552541206800094933936"),
        (T::e, "2.718281828459045235360287471352662497757247093699959574966967627724077"),
        (T::ln_10, "2.302585092994045684017991454684364207601101488628772976033327900967573"),
        (T::log10_e, "0.4342944819032518276511289189166050822943970058036665661144537831658646"),
        (T::log2_e, "1.442695040888963407359924681001892137426645954152985934135449406931109"),
        (T::frac_1_pi, "0.3183098861837906715377675267450287240689192914809128974953346881177936"),
        (T::frac_2_sqrt_pi, "1.128379167095512573896158903121545171688101258657997713688171443421285"),
        (T::frac_pi_3, "1.047197551196597746154214461093167628065723133125035273658314864102605"),
        (T::frac_pi_6, "0.5235987755982988730771072305465838140328615665625176368291574320513027"),
        (T::frac_pi_8, "0.3926990816987241548078304229099378605246461749218882276218680740384771"),
        (T::two_pi, "6.283185307179586476925286766559005768394338798750211641949889184615633"),
        (T::frac_2_pi, "0.6366197723675813430755350534900574481378385829618257949906693762355872"),
        (T::frac_pi_2, "1.570796326794896619231321691639751442098584699687552910487472296153908"),
        (T::frac_pi_4, "0.7853981633974483096156608458198757210492923498437764552437361480769541"),
    ]
}
