//! Properties of `euler_poincare::scalar`.

use euler_poincare::scalar::{Dd, Dual, Number, NumberError, Real, Scalar, dual};
use multidouble::{dd::DD, qd::QD};
use nalgebra::{ComplexField, Matrix2, RealField, Vector1, Vector2};
use num_traits::{Signed, Zero};

/// (text, canonical text, value).
const NUMBERS: &[(&str, &str, f64)] = &[
    ("0", "0", 0.0),
    ("000", "0", 0.0),
    (" 12 ", "12", 12.0),
    ("1200", "1200", 1200.0),
    (".5", "0.5", 0.5),
    ("5.", "5", 5.0),
    ("0.10", "0.1", 0.1),
    ("1e-3", "0.001", 1e-3),
    ("12.5E+2", "1250", 1250.0),
    ("1e300", "1e300", 1e300),
    ("123e-300", "1.23e-298", 123e-300),
    ("9007199254740993", "9007199254740993", 9007199254740992.0),
    ("-1/3", "-1/3", -1.0 / 3.0),
    ("-(1/3)", "-(1/3)", -1.0 / 3.0),
    ("1 - 2 - 3", "1 - 2 - 3", -4.0),
    ("1 - (2 - 3)", "1 - (2 - 3)", 2.0),
    ("(1 - 2) - 3", "1 - 2 - 3", -4.0),
    ("12/6/2", "12/6/2", 1.0),
    ("12/(6/2)", "12/(6/2)", 4.0),
    ("2*(3 + 4)*5", "2*(3 + 4)*5", 70.0),
    ("2 - -3", "2 - -3", 5.0),
    ("--3", "--3", 3.0),
    ("-(2 + 3)*4", "-(2 + 3)*4", -20.0),
    ("2*-3", "2*-3", -6.0),
    ("sqrt ( 16 ) / 2", "sqrt(16)/2", 2.0),
    ("1/2-sqrt(3)/6", "1/2 - sqrt(3)/6", 0.21132486540518713),
    ("2*pi", "2*pi", std::f64::consts::TAU),
];

#[test]
fn numbers_parse_print_and_evaluate() {
    for &(text, canonical, value) in NUMBERS {
        let number = Number::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(number.to_string(), canonical);
        assert_eq!(Number::parse(canonical).unwrap(), number, "{text}");
        assert_eq!(number.eval::<f64>(), Ok(value), "{text}");
    }
}

/// (text, byte offset of the error).
const NONSENSE: &[(&str, usize)] = &[
    ("", 0),
    ("   ", 3),
    ("+1", 0),
    ("1 2", 2),
    ("1+", 2),
    ("1+*2", 2),
    ("(1", 2),
    ("1)", 1),
    ("()", 1),
    (".", 1),
    ("1.2.3", 3),
    ("1e", 2),
    ("1e+", 3),
    ("1e10000", 2),
    ("1e99999999999999999999", 2),
    ("0x10", 1),
    ("2pi", 1),
    ("pie", 0),
    ("tau", 0),
    ("nan", 0),
    ("inf", 0),
    ("sqrt 2", 5),
    ("sqrt", 4),
    ("sqrt()", 5),
    ("2^3", 1),
    ("1,5", 1),
    ("π", 0),
    ("1\u{a0}+ 2", 1),
    ("1/3\0", 3),
];

#[test]
fn nonsense_is_refused_where_it_starts() {
    for &(text, offset) in NONSENSE {
        match Number::parse(text) {
            Err(NumberError::Syntax { text: source, at, .. }) => {
                assert_eq!((source.as_str(), at), (text, offset));
            }
            other => panic!("{text:?}: {other:?}"),
        }
    }
    let long = "1+".repeat(500) + "1";
    assert_eq!(Number::parse(&long), Err(NumberError::TooLong { length: 1001 }));
    assert!(matches!(Number::parse(&("1e9+".repeat(249) + "1")), Err(NumberError::TooLong { .. })));
    assert!(Number::parse(&("1+".repeat(200) + "1")).is_ok());
    for open in ["(", "-", "sqrt("] {
        assert!(matches!(Number::parse(&(open.repeat(51) + "1")), Err(NumberError::TooDeep { .. })), "{open}");
    }
    assert!(Number::parse(&("(".repeat(50) + "1" + &")".repeat(50))).is_ok());
}

#[test]
fn numbers_without_a_value_say_why() {
    let error = |text: &str| Number::parse(text).unwrap().eval::<f64>().unwrap_err();
    assert_eq!(error("1/(2 - 2)"), NumberError::DivisionByZero { divisor: "2 - 2".into() });
    assert_eq!(error("0/0"), NumberError::DivisionByZero { divisor: "0".into() });
    assert_eq!(error("1 + sqrt(1 - 3)"), NumberError::NegativeRoot { argument: "1 - 3".into(), value: -2.0 });
    for text in ["1e309", "1e-400", "1e9999", "1e-9999", "1e300*1e300", "1e-300/1e300", "1e-200*1e-200"] {
        let text: String = text.into();
        assert_eq!(error(&text), NumberError::OutOfRange { text, scalar: "f64" });
    }
    assert!(matches!(Number::from(f64::NAN).eval::<f64>(), Err(NumberError::DivisionByZero { .. })));
    assert_eq!(Number::from(f64::NEG_INFINITY).to_string(), "-1/0");
}

#[test]
fn numbers_from_machine_numbers() {
    assert_eq!(Number::from(0.1).to_string(), "0.1");
    assert_eq!(Number::from(-0.375).to_string(), "-0.375");
    assert_eq!(Number::from(5e-324).to_string(), "5e-324");
    assert_eq!(Number::from(i64::MIN).to_string(), "-9.223372036854775808e18");
    assert_eq!(Number::from(i64::MIN).eval::<f64>(), Ok(-9223372036854775808.0));
    assert_eq!(Number::ratio(-1, 3), Number::parse("-1/3").unwrap());
    assert_eq!(Number::ratio(1, -3), Number::parse("1/-3").unwrap());
    assert_eq!(Number::ratio(7, 1), Number::from(7));
    assert_eq!(Number::root(2), Number::parse("sqrt(2)").unwrap());
    assert_eq!(Number::pi(), Number::parse("pi").unwrap());
    for x in [0.0, 0.1, 1.0 / 3.0, f64::MAX, f64::MIN_POSITIVE, 5e-324, 2f64.powi(60), -2.5e-7] {
        assert_eq!(Number::from(x).eval::<f64>(), Ok(x));
        assert_eq!(Number::parse(&Number::from(x).to_string()), Ok(Number::from(x)));
    }
}

fn quad(x: Dd) -> QD {
    QD::from_dd(DD { hi: x.hi(), lo: x.lo() })
}

/// |x - exact| / |exact| in units of 2^-104.
fn units(x: Dd, exact: QD) -> f64 {
    ((quad(x) - exact) / exact).to_f64().abs() * 2f64.powi(104)
}

fn function(name: &str, x: Dd, second: Dd) -> Dd {
    match name {
        "sqrt" => x.sqrt(),
        "cbrt" => x.cbrt(),
        "exp" => x.exp(),
        "exp_m1" => x.exp_m1(),
        "ln" => x.ln(),
        "ln_1p" => x.ln_1p(),
        "sin" => x.sin(),
        "cos" => x.cos(),
        "tan" => x.tan(),
        "atan" => x.atan(),
        "asin" => x.asin(),
        "acos" => x.acos(),
        "sinh" => x.sinh(),
        "cosh" => x.cosh(),
        "tanh" => x.tanh(),
        "asinh" => x.asinh(),
        "acosh" => x.acosh(),
        "atanh" => x.atanh(),
        "atan2" => x.atan2(second),
        other => panic!("{other}"),
    }
}

type Reference = (&'static str, (f64, f64), (f64, f64), &'static str);

/// (function, argument, second argument of atan2, 40 digits): the arguments are the nearest double-doubles to points
/// such as n/3 x 10^k and n pi/2, and the values `mpmath.nstr(f(mpf(hi) + mpf(lo)), 40)` with mp.prec = 2500.
#[rustfmt::skip]
#[allow(clippy::approx_constant)] // arguments next to multiples of pi
const FUNCTIONS: &[Reference] = &[
    ("sqrt", (2.0, 0.0), (0.0, 0.0), "1.41421356237309504880168872420969807857"),
    ("sqrt", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "5.773502691896257645091487805019565660987e-1"),
    ("sqrt", (3.3333333333333333e-251, 7.844323606247282e-268), (0.0, 0.0), "5.773502691896257645091487805019571916048e-126"),
    ("sqrt", (3.3333333333333335e+299, -1.7501586751734807e+283), (0.0, 0.0), "5.773502691896257645091487805019576538066e+149"),
    ("cbrt", (2.0, 0.0), (0.0, 0.0), "1.25992104989487316476721060727822835057"),
    ("cbrt", (-0.3333333333333333, -1.850371707708594e-17), (0.0, 0.0), "-6.933612743506347048433522747859610832511e-1"),
    ("cbrt", (3.3333333333333335e+299, -1.7501586751734807e+283), (0.0, 0.0), "6.933612743506347048433522747859619540969e+99"),
    ("exp", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "1.395612425086089528628125319602585404077"),
    ("exp", (-0.3333333333333333, -1.850371707708594e-17), (0.0, 0.0), "7.165313105737892504256040969253804034473e-1"),
    ("exp", (3.3333333333333333e-31, 1.4149111375716938e-48), (0.0, 0.0), "1.000000000000000000000000000000333333333"),
    ("exp", (33.333333333333336, -2.3684757858670005e-15), (0.0, 0.0), "2.995592469141818644035958350975492630311e+14"),
    ("exp", (-600.3333333333334, 3.789561257387201e-14), (0.0, 0.0), "1.899092115664432316357271769527552526847e-261"),
    ("exp", (709.3333333333334, -3.789561257387201e-14), (0.0, 0.0), "1.146971156776634783227384614205036178667e+308"),
    ("exp_m1", (3.3333333333333336e-101, -2.781348191183137e-117), (0.0, 0.0), "3.333333333333333333333333333333336019149e-101"),
    ("exp_m1", (-0.3333333333333333, -1.850371707708594e-17), (0.0, 0.0), "-2.834686894262107495743959030746195965527e-1"),
    ("exp_m1", (0.6666666666666666, 3.700743415417188e-17), (0.0, 0.0), "9.477340410546758566390212079283413130803e-1"),
    ("exp_m1", (-50.333333333333336, 2.3684757858670005e-15), (0.0, 0.0), "-9.999999999999999999998617990343669417229e-1"),
    ("ln", (2.0, 0.0), (0.0, 0.0), "6.931471805599453094172321214581765680755e-1"),
    ("ln", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "-1.098612288668109691395245236922528786135"),
    ("ln", (1.0, 3.3333333333333333e-21), (0.0, 0.0), "3.333333333333333275891413379520350800399e-21"),
    ("ln", (0.9999999966666666, 5.375663173860327e-17), (0.0, 0.0), "-3.333333338888888901234569775072431943887e-9"),
    ("ln", (3.3333333333333335e+299, -1.7501586751734807e+283), (0.0, 0.0), "6.896769156095455955140021911683867372621e+2"),
    ("ln", (3.3333333333333333e-251, 7.844323606247282e-268), (0.0, 0.0), "-5.767448855371795306958931089080135785196e+2"),
    ("ln", (0.7072, -5.0803805606847164e-17), (0.0, 0.0), "-3.464417676587033726827831520081299093306e-1"),
    ("ln", (1.4141, 8.739675649849232e-17), (0.0, 0.0), "3.464932863315937542787841527653571180989e-1"),
    ("ln_1p", (3.3333333333333336e-101, -2.781348191183137e-117), (0.0, 0.0), "3.333333333333333333333333333333336019149e-101"),
    ("ln_1p", (-0.3333333333333333, -1.850371707708594e-17), (0.0, 0.0), "-4.05465108108164381978013115464347595828e-1"),
    ("ln_1p", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "2.876820724517809274392190059938266611315e-1"),
    ("ln_1p", (-0.9996666666666667, 3.671137468093851e-17), (0.0, 0.0), "-8.006367567650246743449219600976407188356"),
    ("ln_1p", (333.3333333333333, 1.8947806286936004e-14), (0.0, 0.0), "5.812138499293825839470339754670295308998"),
    ("sin", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "3.271946967961522441733440852676196354398e-1"),
    ("sin", (3.3333333333333335e-201, -1.8207050131857237e-217), (0.0, 0.0), "3.33333333333333333333333333333331442801e-201"),
    ("sin", (3.141592653589793, 1.2246467991473532e-16), (0.0, 0.0), "-2.994769809718339554641594267875450189973e-33"),
    ("sin", (6.283185307179586, 2.4492935982947064e-16), (0.0, 0.0), "5.989539619436679109283188535750900379947e-33"),
    ("sin", (-99999.66666666667, 4.850638409455617e-12), (0.0, 0.0), "-3.607666313457630188444263085088411440349e-1"),
    ("sin", (99996.89416376312, -2.6886803988101036e-12), (0.0, 0.0), "4.752430362647330115407859644945685552496e-30"),
    ("sin", (22.0, 0.0), (0.0, 0.0), "-8.851309290403875921690256815772332463289e-3"),
    ("sin", (333333333333.3333, 2.0345052083333332e-05), (0.0, 0.0), "9.540297973149584916227671179116331975484e-1"),
    ("cos", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "9.44956946314737664388284007675880943928e-1"),
    ("cos", (1.5707963267948966, 6.123233995736766e-17), (0.0, 0.0), "-1.497384904859169777320797133937725094987e-33"),
    ("cos", (99998.46496008991, -1.2533624721558478e-13), (0.0, 0.0), "7.95412839749254776761938441427276114105e-30"),
    ("cos", (0.7853981633974483, 3.061616997868383e-17), (0.0, 0.0), "7.071067811865475244008443621048485098793e-1"),
    ("cos", (99999.66666666667, -4.850638409455617e-12), (0.0, 0.0), "-9.326561197501629646478077073407365887197e-1"),
    ("cos", (-11.0, 0.0), (0.0, 0.0), "4.425697988050785748355024723941573225727e-3"),
    ("tan", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "3.46253549510575491038543565609739624285e-1"),
    ("tan", (1.5707963267948966, 6.123233995736766e-17), (0.0, 0.0), "-6.678309610006725578349480965456798956213e+32"),
    ("tan", (-33.333333333333336, 2.3684757858670005e-15), (0.0, 0.0), "2.768610163933420861599553712662715142452"),
    ("atan", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "3.217505543966421934014046143586603945744e-1"),
    ("atan", (-3.3333333333333336e-101, 2.781348191183137e-117), (0.0, 0.0), "-3.333333333333333333333333333333336019149e-101"),
    ("atan", (3.333333333333333e+99, 1.0887943731961103e+83), (0.0, 0.0), "1.570796326794896619231321691639751442099"),
    ("atan", (1.0, 0.0), (0.0, 0.0), "7.853981633974483096156608458198757210493e-1"),
    ("asin", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "3.398369094541219370963925133917629769177e-1"),
    ("asin", (1.0, -3.3333333333333333e-21), (0.0, 0.0), "1.570796326713246961138549089069934886429"),
    ("asin", (-3.3333333333333336e-101, 2.781348191183137e-117), (0.0, 0.0), "-3.333333333333333333333333333333336019149e-101"),
    ("acos", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "1.230959417340774682134929178247988465181"),
    ("acos", (1.0, -3.3333333333333333e-21), (0.0, 0.0), "8.164965809277260256981655566933533895615e-11"),
    ("acos", (-0.9999999999666667, -2.758012366636346e-18), (0.0, 0.0), "3.141584488623983938521855477516266252264"),
    ("acos", (3.3333333333333333e-31, 1.4149111375716938e-48), (0.0, 0.0), "1.570796326794896619231321691639418108765"),
    ("sinh", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "3.395405572561501391012606113386025003148e-1"),
    ("sinh", (-5.333333333333333, -2.9605947323337506e-16), (0.0, 0.0), "-1.035612104699203723590297350047535341726e+2"),
    ("sinh", (3.3333333333333336e-101, -2.781348191183137e-117), (0.0, 0.0), "3.333333333333333333333333333333336019149e-101"),
    ("sinh", (-700.3333333333334, 3.789561257387201e-14), (0.0, 0.0), "-7.07737428754383567669279751203224691356e+303"),
    ("sinh", (710.3333333333334, -3.789561257387201e-14), (0.0, 0.0), "1.55889542661628851542685514156281065508e+308"),
    ("cosh", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "1.056071867829939389526864708263982903762"),
    ("cosh", (-5.333333333333333, -2.9605947323337506e-16), (0.0, 0.0), "1.035660384199142037991284622278223515446e+2"),
    ("cosh", (-700.3333333333334, 3.789561257387201e-14), (0.0, 0.0), "7.07737428754383567669279751203224691356e+303"),
    ("cosh", (710.3333333333334, -3.789561257387201e-14), (0.0, 0.0), "1.55889542661628851542685514156281065508e+308"),
    ("tanh", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "3.215127375316343447194062224252055450209e-1"),
    ("tanh", (-3.3333333333333336e-101, 2.781348191183137e-117), (0.0, 0.0), "-3.333333333333333333333333333333336019149e-101"),
    ("tanh", (-30.333333333333332, -1.1842378929335002e-15), (0.0, 0.0), "-9.999999999999999999999999910085149428769e-1"),
    ("asinh", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "3.274501502372584433225352599882571532485e-1"),
    ("asinh", (-3.3333333333333336e-101, 2.781348191183137e-117), (0.0, 0.0), "-3.333333333333333333333333333333336019149e-101"),
    ("asinh", (-333.3333333333333, -1.8947806286936004e-14), (0.0, 0.0), "-6.50229242086637895804448699711220182478"),
    ("asinh", (3.3333333333333333e+249, -1.9525313633700003e+231), (0.0, 0.0), "5.752408081404032566225198505556267028153e+2"),
    ("acosh", (1.0, 3.333333333333333e-26), (0.0, 0.0), "2.581988897471611158283945405949306817927e-13"),
    ("acosh", (1.3333333333333333, 7.401486830834377e-17), (0.0, 0.0), "7.953654612239056305278909331478016422048e-1"),
    ("acosh", (3.3333333333333333e+249, -1.9525313633700003e+231), (0.0, 0.0), "5.752408081404032566225198505556267028153e+2"),
    ("atanh", (0.3333333333333333, 1.850371707708594e-17), (0.0, 0.0), "3.465735902799726547086160607290871284798e-1"),
    ("atanh", (-3.3333333333333336e-101, 2.781348191183137e-117), (0.0, 0.0), "-3.333333333333333333333333333333336019149e-101"),
    ("atanh", (-0.9999999999999997, 2.664259457863712e-19), (0.0, 0.0), "-1.816526793206937004721077794567168613233e+1"),
    ("atanh", (0.9999999999999997, -2.664259457863712e-19), (0.0, 0.0), "1.816526793206937004721077794567168613233e+1"),
    ("atan2", (1.0, 0.0), (2.0, 0.0), "4.636476090008061162142562314612144020285e-1"),
    ("atan2", (1.0, 0.0), (-2.0, 0.0), "2.677945044588987122248387151818288482169"),
    ("atan2", (-1.0, 0.0), (2.0, 0.0), "-4.636476090008061162142562314612144020285e-1"),
    ("atan2", (-1.0, 0.0), (-2.0, 0.0), "-2.677945044588987122248387151818288482169"),
    ("atan2", (0.3333333333333333, 1.850371707708594e-17), (1e-100, -1.9991899802602883e-117), "1.570796326794896619231321691639751442099"),
    ("atan2", (3.3333333333333336e-101, -2.781348191183137e-117), (-1.0, 0.0), "3.141592653589793238462643383279502884197"),
    ("atan2", (3.3333333333333333e-21, 5.743636439825742e-38), (1.0, 0.0), "3.333333333333333333333333333333329018761e-21"),
    ("atan2", (3.3333333333333333e+289, 8.275980817800079e+272), (1e+290, -6.172783352786716e+273), "3.217505543966421934014046143586609586599e-1"),
    ("atan2", (3.3333333333333333e-251, 7.844323606247282e-268), (-1e-250, 5.39995372538839e-267), "2.81984209919315104506123876892084188797"),
    ("atan2", (-0.6666666666666666, -3.700743415417188e-17), (1e+200, 3.0266877787489637e+183), "-6.666666666666666666666666666666656702797e-201"),
];

#[test]
fn double_double_functions_have_all_their_digits() {
    for &(name, x, second, exact) in FUNCTIONS {
        let value = function(name, Dd::new(x.0, x.1), Dd::new(second.0, second.1));
        let error = units(value, QD::parse(exact).unwrap());
        // Compositions: at most some four roundings of 1.25 units.
        assert!(error <= 4.0, "{name}{x:?} = {value}, {error} units from {exact}");
    }
}

type Constant = fn() -> Dd;

/// The same, `mpmath.nstr(.., 40)`.
#[rustfmt::skip]
const CONSTANTS: &[(Constant, &str)] = &[
    (Dd::pi, "3.141592653589793238462643383279502884197"),
    (Dd::ln_2, "0.6931471805599453094172321214581765680755"),
    (Dd::e, "2.718281828459045235360287471352662497757"),
    (Dd::ln_10, "2.302585092994045684017991454684364207601"),
    (Dd::log10_e, "0.4342944819032518276511289189166050822944"),
    (Dd::log2_e, "1.442695040888963407359924681001892137427"),
    (Dd::frac_1_pi, "0.3183098861837906715377675267450287240689"),
    (Dd::frac_2_sqrt_pi, "1.128379167095512573896158903121545171688"),
    (Dd::frac_pi_3, "1.047197551196597746154214461093167628066"),
    (Dd::frac_pi_6, "0.5235987755982988730771072305465838140329"),
    (Dd::frac_pi_8, "0.3926990816987241548078304229099378605246"),
    (Dd::two_pi, "6.283185307179586476925286766559005768394"),
    (Dd::frac_2_pi, "0.6366197723675813430755350534900574481378"),
    (Dd::frac_pi_2, "1.570796326794896619231321691639751442099"),
    (Dd::frac_pi_4, "0.7853981633974483096156608458198757210493"),
];

#[test]
fn double_double_constants() {
    for (constant, exact) in CONSTANTS {
        let error = units(constant(), QD::parse(exact).unwrap());
        assert!(error <= 4.0, "{exact}: {error} units");
    }
}

/// A reproducible sequence in [0, 1).
fn uniform(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / 2f64.powi(53)
}

#[test]
fn double_double_operations_keep_their_round_off() {
    let state = &mut 0x9e37_79b9_7f4a_7c15;
    let mut number = |scale: i32| {
        let hi = (1.0 + uniform(state)) * if uniform(state) < 0.5 { -1.0 } else { 1.0 };
        let lo = (uniform(state) - 0.5) * f64::EPSILON;
        let factor = 2f64.powi(((uniform(state) - 0.5) * f64::from(scale)) as i32);
        Dd::new(hi * factor, lo * factor)
    };
    // In units of 2^-106: 3 for a sum, 5 for a product; the quotient's three partial quotients stay below 8 as well.
    let mut worst = [0.0f64; 4];
    for i in 0..100_000 {
        let scale = if i % 2 == 0 { 2 } else { 400 };
        let (a, b) = (number(scale), number(scale));
        let exact = [
            quad(a).ieee_add(quad(b)),
            quad(a).ieee_sub(quad(b)),
            quad(a).accurate_mul(quad(b)),
            quad(a).accurate_div(quad(b)),
        ];
        for (worst, (value, exact)) in worst.iter_mut().zip([a + b, a - b, a * b, a / b].into_iter().zip(exact)) {
            *worst = worst.max(4.0 * units(value, exact));
        }
    }
    let [sum, difference, product, quotient] = worst;
    assert!(sum <= 3.0 && difference <= 3.0 && product <= 5.0 && quotient <= 8.0, "{worst:?}");
    // The bounds are not idle.
    assert!(worst.iter().all(|&w| w > 0.5), "{worst:?}");
    assert_eq!(Dd::unit_roundoff().to_f64(), 8.0 * 2f64.powi(-106));
}

#[test]
fn what_is_not_finite_is_seen() {
    let (zero, one, huge) = (Dd::exact(0.0), Dd::exact(1.0), Dd::exact(f64::MAX));
    let infinity = Dd::exact(f64::INFINITY);
    let bad = [
        one / zero,
        zero / zero,
        huge * huge,
        huge + huge,
        infinity - infinity,
        infinity + one,
        infinity * one,
        Dd::exact(f64::NAN),
        Dd::exact(-1.0).sqrt(),
        Dd::exact(-1e300).sqrt(),
        Dd::exact(-1.0).ln(),
        zero.ln(),
        Dd::exact(-1.0).ln_1p(),
        Dd::exact(-2.0).ln_1p(),
        Dd::exact(1000.0).exp(),
        Dd::exact(709.9).exp(),
        Dd::exact(1000.0).exp_m1(),
        infinity.sin(),
        Dd::exact(1e300).cos(),
        Dd::exact(1.5).asin(),
        Dd::exact(0.5).acosh(),
        one.atanh(),
        Dd::exact(f64::NAN).exp(),
        Dd::exact(f64::NAN).atan2(one),
        Dd::exact(f64::NAN).floor(),
    ];
    for (i, x) in bad.into_iter().enumerate() {
        assert!(!x.all_finite(), "{i}: {x:?}");
        assert!(!Dual { re: one, eps: x }.all_finite());
    }
    assert_eq!(Dd::exact(1000.0).exp().hi(), f64::INFINITY);
    assert_eq!(Dd::exact(-1000.0).exp(), zero);
    assert_eq!(Dd::exact(-1000.0).exp_m1(), -one);
    assert_eq!(zero.ln().hi(), f64::NEG_INFINITY);
    assert!(Dd::exact(f64::NAN).partial_cmp(&one).is_none());
}

#[test]
fn angles_have_the_conventions_of_f64() {
    for (y, x) in [
        (0.0, 1.0),
        (-0.0, 1.0),
        (0.0, -1.0),
        (-0.0, -1.0),
        (0.0, 0.0),
        (-0.0, 0.0),
        (0.0, -0.0),
        (-0.0, -0.0),
        (1.0, 0.0),
        (-1.0, 0.0),
        (1.0, -0.0),
        (f64::INFINITY, 1.0),
        (1.0, f64::INFINITY),
        (-1.0, f64::NEG_INFINITY),
        (f64::INFINITY, f64::NEG_INFINITY),
        (3.0, -4.0),
        (-3.0, -4.0),
        (-3.0, 4.0),
    ] {
        let (ours, theirs) = (Dd::exact(y).atan2(Dd::exact(x)).to_f64(), f64::atan2(y, x));
        assert_eq!(ours.to_bits(), theirs.to_bits(), "({y}, {x}): {ours} {theirs}");
    }
}

#[test]
fn decimals_in_and_out() {
    for (text, printed, scientific, cents) in [
        ("0.1", "0.1", "1e-1", "0.10"),
        ("-2.5", "-2.5", "-2.5e0", "-2.50"),
        ("1234567.125", "1234567.125", "1.234567125e6", "1234567.12"),
        ("9.9999", "9.9999", "9.9999e0", "10.00"),
        ("1e40", "1e40", "1e40", "10000000000000000000000000000000000000000.00"),
        ("3e-9", "3e-9", "3e-9", "0.00"),
        (
            "0.123456789012345678901234567890",
            "0.12345678901234567890123456789",
            "1.2345678901234567890123456789e-1",
            "0.12",
        ),
    ] {
        let x = Dd::parse_decimal(text).unwrap();
        assert_eq!(format!("{x}"), printed);
        assert_eq!(format!("{x:e}"), scientific);
        assert_eq!(format!("{x:.2}"), cents);
        assert!(units(x, QD::parse(text).unwrap()) <= 0.25);
    }
    assert_eq!(format!("{:>8.3}|{:.4e}|{:.0}", Dd::pi(), Dd::pi(), Dd::pi()), "   3.142|3.1416e0|3");
    assert_eq!(format!("{} {} {}", Dd::exact(0.0), Dd::exact(f64::NAN), Dd::exact(f64::INFINITY)), "0 NaN inf");
    for bad in ["", "x", "nan", "inf", "1e400", "-1e999999999999", "1..2", "1e", "0x1", "--1"] {
        assert_eq!(Dd::parse_decimal(bad), None, "{bad}");
        assert_eq!(f64::parse_decimal(bad), None, "{bad}");
    }
    assert_eq!(Dd::parse_decimal("1e-999999999999"), Some(Dd::exact(0.0)));
    assert_eq!(Dd::int(i64::MAX) - Dd::int(i64::MAX - 1), Dd::exact(1.0));
    assert_eq!(Dd::int(i64::MIN), Dd::exact(-(2f64.powi(63))));
}

#[test]
fn numbers_keep_their_digits() {
    let dd = |text: &str| Number::parse(text).unwrap().eval::<Dd>().unwrap();
    assert_eq!(Number::from(0.1).eval::<Dd>().unwrap(), Dd::ratio(1, 10));
    assert_eq!(Number::from(0.375).eval::<Dd>().unwrap(), Dd::exact(0.375));
    assert!(units(dd("1/3"), QD::ONE / QD::from_f64(3.0)) < 1.0);
    // mpmath.nstr(mpf(1)/2 - sqrt(mpf(3))/6, 40); the difference magnifies the round-off of 1/2 by 2.4.
    assert!(units(dd("1/2 - sqrt(3)/6"), QD::parse("0.2113248654051871177454256097490212721762").unwrap()) < 4.0);
    assert!(units(dd("2*pi"), QD::TWO_PI) < 1.0);
    assert_eq!(
        Number::parse("1e309").unwrap().eval::<Dd>(),
        Err(NumberError::OutOfRange { text: "1e309".into(), scalar: "dd" })
    );
    assert!(matches!(Number::parse("1e200*1e200").unwrap().eval::<Dd>(), Err(NumberError::OutOfRange { .. })));
    assert!(matches!(Number::parse("sqrt(-1)").unwrap().eval::<Dd>(), Err(NumberError::NegativeRoot { .. })));
    assert!(matches!(Number::parse("1/0").unwrap().eval::<Dd>(), Err(NumberError::DivisionByZero { .. })));
}

#[test]
fn rounding_signs_and_powers() {
    // One unit of the second part below and above.
    let tiny = Dd::exact(2f64.powi(-100));
    let d = |x: f64| Dd::exact(x);
    for (x, floor, ceil, round, trunc) in [
        (d(2.0), 2.0, 2.0, 2.0, 2.0),
        (d(2.0) - tiny, 1.0, 2.0, 2.0, 1.0),
        (d(2.0) + tiny, 2.0, 3.0, 2.0, 2.0),
        (d(-2.0) + tiny, -2.0, -1.0, -2.0, -1.0),
        (d(-2.0) - tiny, -3.0, -2.0, -2.0, -2.0),
        (d(0.5), 0.0, 1.0, 1.0, 0.0),
        (d(-0.5), -1.0, 0.0, -1.0, 0.0),
        (d(0.5) - Dd::exact(2f64.powi(-107)), 0.0, 1.0, 0.0, 0.0),
        (d(2.5) - tiny, 2.0, 3.0, 2.0, 2.0),
        (d(-2.5) - tiny, -3.0, -2.0, -3.0, -2.0),
    ] {
        let values = [x.floor(), x.ceil(), x.round(), x.trunc()];
        assert_eq!(values, [floor, ceil, round, trunc].map(d), "{x}");
        assert_eq!(x.fract(), x - d(trunc));
    }
    assert_eq!((d(2f64.powi(60)) + d(0.75)).floor(), d(2f64.powi(60)));
    assert_eq!(d(7.5) % d(2.0), d(1.5));
    assert_eq!(d(-7.5) % d(2.0), d(-1.5));
    assert_eq!((d(-3.0).signum(), (-tiny).signum(), tiny.signum()), (d(-1.0), d(-1.0), d(1.0)));
    assert!(tiny.is_positive() && (-tiny).is_negative() && !d(0.0).is_positive() && d(0.0).is_zero());
    assert_eq!(Signed::abs(&-tiny), tiny);
    assert_eq!(d(3.0).copysign(-tiny), d(-3.0));
    let nan = d(f64::NAN);
    assert_eq!((RealField::max(nan, d(1.0)), RealField::max(d(1.0), nan)), (d(1.0), d(1.0)));
    assert_eq!((RealField::min(nan, d(1.0)), RealField::min(d(1.0), nan)), (d(1.0), d(1.0)));
    assert_eq!(RealField::max(d(1.0), d(1.0) + tiny), d(1.0) + tiny);
    assert_eq!(RealField::clamp(d(3.0), d(1.0), d(2.0)), d(2.0));
    assert_eq!(d(2.0).powi(-3), d(0.125));
    assert_eq!((d(-3.0).powi(3), d(-3.0).powi(0), d(0.0).powi(0)), (d(-27.0), d(1.0), d(1.0)));
    assert_eq!(d(3.0).hypot(d(-4.0)), d(5.0));
    assert!(
        units(
            d(3e290).hypot(d(4e290)),
            QD::from_f64(4e290)
                * (QD::ONE + QD::from_f64(3e290) / QD::from_f64(4e290) * (QD::from_f64(3e290) / QD::from_f64(4e290)))
                    .sqrt()
        ) < 4.0
    );
    assert_eq!((d(-1.0).try_sqrt(), d(4.0).try_sqrt()), (None, Some(d(2.0))));
}

/// f, f' and f'' by hand, and a point.
struct Derivatives<T: Real> {
    name: &'static str,
    f: fn(Dual<Dual<T>>) -> Dual<Dual<T>>,
    first: fn(T) -> T,
    second: fn(T) -> T,
}

fn hand_derivatives<T: Real>() -> Vec<Derivatives<T>> {
    macro_rules! table {
        ($($name:literal: $f:expr, $first:expr, $second:expr;)*) => {
            vec![$(Derivatives { name: $name, f: $f, first: $first, second: $second }),*]
        };
    }
    table! {
        "square": |x| x * x, |x| x + x, |_| T::int(2);
        "quotient": |x| Dual::int(1) / (x - Dual::int(2)),
            |x| -(x - T::int(2)).powi(-2), |x| T::int(2) * (x - T::int(2)).powi(-3);
        "sqrt": |x| x.sqrt(), |x| T::half() / x.sqrt(), |x| -T::ratio(1, 4) / (x * x.sqrt());
        "cbrt": |x| x.cbrt(), |x| T::ratio(1, 3) * x.cbrt() / x, |x| -T::ratio(2, 9) * x.cbrt() / (x * x);
        "exp": |x| x.exp(), |x| x.exp(), |x| x.exp();
        "exp_m1": |x| x.exp_m1(), |x| x.exp(), |x| x.exp();
        "ln": |x| x.ln(), |x| T::one() / x, |x| -T::one() / (x * x);
        "ln_1p": |x| x.ln_1p(), |x| T::one() / (T::one() + x), |x| -(T::one() + x).powi(-2);
        "sin": |x| x.sin(), |x| x.cos(), |x| -x.sin();
        "cos": |x| x.cos(), |x| -x.sin(), |x| -x.cos();
        "tan": |x| x.tan(), |x| x.cos().powi(-2), |x| T::int(2) * x.tan() * x.cos().powi(-2);
        "atan": |x| x.atan(), |x| T::one() / (T::one() + x * x), |x| -(x + x) * (T::one() + x * x).powi(-2);
        "asin": |x| x.asin(), |x| T::one() / (T::one() - x * x).sqrt(),
            |x| x / (T::one() - x * x).sqrt().powi(3);
        "acos": |x| x.acos(), |x| -T::one() / (T::one() - x * x).sqrt(),
            |x| -x / (T::one() - x * x).sqrt().powi(3);
        "sinh": |x| x.sinh(), |x| x.cosh(), |x| x.sinh();
        "cosh": |x| x.cosh(), |x| x.sinh(), |x| x.cosh();
        "tanh": |x| x.tanh(), |x| x.cosh().powi(-2), |x| -T::int(2) * x.tanh() * x.cosh().powi(-2);
        "asinh": |x| x.asinh(), |x| T::one() / (T::one() + x * x).sqrt(),
            |x| -x / (T::one() + x * x).sqrt().powi(3);
        "acosh": |x| (x + Dual::int(2)).acosh(), |x| T::one() / ((x + T::int(2)).powi(2) - T::one()).sqrt(),
            |x| -(x + T::int(2)) / ((x + T::int(2)).powi(2) - T::one()).sqrt().powi(3);
        "atanh": |x| x.atanh(), |x| T::one() / (T::one() - x * x), |x| (x + x) * (T::one() - x * x).powi(-2);
        "powi": |x| x.powi(-3), |x| -T::int(3) * x.powi(-4), |x| T::int(12) * x.powi(-5);
        "powf": |x| x.powf(Dual::ratio(5, 2)), |x| T::ratio(5, 2) * x * x.sqrt(), |x| T::ratio(15, 4) * x.sqrt();
        "hypot": |x| x.hypot(Dual::int(2)), |x| x / (x * x + T::int(4)).sqrt(),
            |x| T::int(4) / (x * x + T::int(4)).sqrt().powi(3);
        "remainder": |x| (x * x) % Dual::ratio(1, 100), |x| x + x, |_| T::int(2);
    }
}

fn duals_agree_with_hand<T: Real>() {
    // Each side is some twenty roundings, magnified by at most 1/(1 - x^2)^2 and the like: below 16 here.
    let tolerance = T::int(20 * 16) * T::unit_roundoff();
    for x in [T::ratio(1, 3), T::ratio(7, 10)] {
        let variable = Dual { re: Dual::variable(x), eps: Dual::constant(T::one()) };
        for Derivatives { name, f, first, second } in hand_derivatives::<T>() {
            let y = f(variable);
            for (ours, hand) in [(y.re.eps, first(x)), (y.eps.re, first(x)), (y.eps.eps, second(x))] {
                let error = Signed::abs(&(ours - hand));
                assert!(error <= tolerance * (T::one() + Signed::abs(&hand)), "{} {name}({x}): {ours} {hand}", T::NAME);
            }
        }
    }
}

#[test]
fn dual_numbers_carry_first_and_second_derivatives() {
    duals_agree_with_hand::<f64>();
    duals_agree_with_hand::<Dd>();
}

#[test]
fn dual_derivatives_at_the_edges() {
    type F = fn(Dual<f64>) -> Dual<f64>;
    // Odd functions with slope 1 at 0, whichever zero it is.
    for zero in [0.0, -0.0] {
        let odd: [F; 9] = [
            |x| x.sin(),
            |x| x.tan(),
            |x| x.asin(),
            |x| x.atan(),
            |x| x.sinh(),
            |x| x.tanh(),
            |x| x.asinh(),
            |x| x.atanh(),
            |x| x.exp_m1(),
        ];
        for (i, f) in odd.into_iter().enumerate() {
            let y = f(Dual::variable(zero));
            assert_eq!((y.re, y.eps), (0.0, 1.0), "{i}");
        }
        assert_eq!(Dual::variable(zero).cosh().eps, 0.0);
    }
    // A derivative that does not exist is not finite.
    assert!(!Dual::variable(0.0).sqrt().all_finite());
    assert!(!Dual::variable(0.0).atan2(Dual::constant(0.0)).all_finite());
    assert!(!(Dual::int(1) / Dual::<f64>::int(0)).all_finite());
    // atan2: the gradient is (x, -y)/r², in all quadrants and at any size.
    for size in [1.0, 1e-170, 1e170] {
        for (y, x) in [(3.0, 4.0), (3.0, -4.0), (-3.0, 4.0), (-3.0, -4.0)] {
            let along_y = Dual::variable(y * size).atan2(Dual::constant(x * size));
            let along_x = Dual::constant(y * size).atan2(Dual::variable(x * size));
            assert!((along_y.eps * size - x / 25.0).abs() < 1e-15 && (along_x.eps * size + y / 25.0).abs() < 1e-15);
            assert_eq!(along_y.re, f64::atan2(y, x));
        }
    }
    // Comparison is that of the values; rounding has derivative 0, the absolute value the sign.
    assert!(Dual { re: 1.0, eps: 5.0 } == Dual { re: 1.0, eps: -5.0 } && Dual::variable(1.0) < Dual::variable(2.0));
    assert_eq!((Dual::variable(1.5).floor().eps, Signed::abs(&Dual::variable(-1.5)).eps), (0.0, -1.0));
    assert_eq!(Dual::variable(Dd::exact(2.0)).to_string(), "2 + 1 ε");
}

#[test]
fn directional_derivatives() {
    // f(x, y) = (x² y, sin x), along (1, 2): (2xy + 2x², cos x).
    let f = |v: &Vector2<Dual<Dd>>| Ok::<_, ()>(Vector2::new(v.x * v.x * v.y, v.x.sin()));
    let (x, y) = (Dd::ratio(1, 3), Dd::ratio(5, 7));
    let slope = dual::derivative(f, &Vector2::new(x, y), &Vector2::new(Dd::int(1), Dd::int(2))).unwrap();
    let hand = Vector2::new(Dd::int(2) * x * y + Dd::int(2) * x * x, x.cos());
    assert!((slope - hand).amax() <= Dd::int(8) * Dd::unit_roundoff());
    let refused = dual::derivative(
        |_: &Vector1<Dual<f64>>| Err::<Vector1<Dual<f64>>, _>("no"),
        &Vector1::new(1.0),
        &Vector1::new(1.0),
    );
    assert_eq!(refused, Err("no"));
}

#[test]
fn linear_algebra_runs_on_them() {
    // The inverse of A(t) has derivative -A⁻¹ A' A⁻¹.
    let a = Matrix2::new(2, 1, -1, 3).map(|n: i64| Dual { re: Dd::int(n), eps: Dd::ratio(n, 3) * Dd::int(n) });
    let inverse = a.lu().try_inverse().unwrap();
    let (values, slopes) = (inverse.map(|x| x.re), a.map(|x| x.eps));
    let defect = inverse.map(|x| x.eps) + values * slopes * values;
    assert!(defect.amax() <= Dd::int(16) * Dd::unit_roundoff());
    assert!((values * a.map(|x| x.re) - Matrix2::identity()).amax() <= Dd::int(16) * Dd::unit_roundoff());
}

#[cfg(feature = "harness")]
mod with_harness {
    use super::*;
    use proptest::prelude::*;

    #[derive(serde::Serialize, serde::Deserialize, PartialEq, Debug)]
    struct Row {
        x: Number,
    }

    #[test]
    fn numbers_are_written_as_numbers_where_nothing_is_lost() {
        for (text, json) in [
            ("3", "3"),
            ("-3", "-3"),
            ("0", "0"),
            ("-0", "-0.0"),
            ("0.1", "0.1"),
            ("1e300", "1e+300"),
            ("1e400", "\"1e400\""),
            ("--3", "\"--3\""),
            ("0.10000000000000000000000000001", "\"0.10000000000000000000000000001\""),
            ("1/3", "\"1/3\""),
        ] {
            let row = Row { x: Number::parse(text).unwrap() };
            let written = serde_json::to_string(&row).unwrap();
            assert_eq!(written, format!("{{\"x\":{json}}}"));
            assert_eq!(serde_json::from_str::<Row>(&written).unwrap(), row);
            let written = toml::to_string(&row).unwrap();
            assert_eq!(toml::from_str::<Row>(&written).unwrap(), row, "{written}");
        }
        assert_eq!(toml::from_str::<Row>("x = 1e3").unwrap().x, Number::from(1000));
        assert_eq!(
            serde_json::from_str::<Number>("18446744073709551615").unwrap().to_string(),
            "1.8446744073709551615e19"
        );
        for bad in ["x = nan", "x = -inf", "x = true", "x = \"1//2\"", "x = [1]", "x = \"\""] {
            assert!(toml::from_str::<Row>(bad).is_err(), "{bad}");
        }
    }

    /// Texts of the grammar, by construction.
    fn expression() -> impl Strategy<Value = String> {
        let leaf =
            prop_oneof!["[0-9]{1,4}", "[0-9]{0,3}\\.[0-9]{1,4}", "[0-9]{1,3}e-?[0-9]{1,2}", Just("pi".to_string()),];
        leaf.prop_recursive(4, 16, 2, |inner| {
            prop_oneof![
                (inner.clone(), "[-+*/]", inner.clone()).prop_map(|(a, o, b)| format!("{a} {o}{b}")),
                (inner.clone(), "[-+*/]", inner.clone()).prop_map(|(a, o, b)| format!("({a}){o} ({b})")),
                inner.clone().prop_map(|a| format!("-({a})")),
                inner.prop_map(|a| format!("sqrt({a})")),
            ]
        })
    }

    proptest! {
        #[test]
        fn any_number_prints_what_parses_back(text in expression()) {
            let number = Number::parse(&text).unwrap();
            prop_assert_eq!(Number::parse(&number.to_string()).unwrap(), number.clone());
            let json = serde_json::to_string(&number).unwrap();
            prop_assert_eq!(serde_json::from_str::<Number>(&json).unwrap(), number);
        }

        #[test]
        fn any_text_is_parsed_or_refused(text in "[-+*/() .0-9episqrtπ]{0,40}") {
            if let Ok(number) = Number::parse(&text) {
                prop_assert_eq!(Number::parse(&number.to_string()).unwrap(), number.clone());
                let _ = number.eval::<f64>();
            }
        }

        #[test]
        fn any_finite_double_survives(x in prop::num::f64::ANY.prop_filter("finite", |x| x.is_finite())) {
            let number = Number::from(x);
            prop_assert_eq!(number.eval::<f64>().unwrap().to_bits(), x.to_bits());
            prop_assert_eq!(Number::parse(&number.to_string()).unwrap(), number);
        }
    }
}
