//! Identities that tie the numbers of trees, their densities and their symmetries together.

use euler_poincare::tableau::failing::formula;
use euler_poincare::tableau::trees::Catalogue;

fn factorial(n: usize) -> u64 {
    (1..=n as u64).product()
}

#[test]
fn counts_are_the_known_sequences() {
    // A000081, A000151, A006964 of the On-Line Encyclopedia of Integer Sequences, and A000238 for oriented trees.
    let known: [&[usize]; 3] = [
        &[1, 1, 2, 4, 9, 20, 48, 115, 286, 719, 1842, 4766, 12486, 32973],
        &[1, 2, 7, 26, 107, 458, 2058, 9498, 44947],
        &[1, 3, 15, 82, 495, 3144, 20875],
    ];
    for (colours, counts) in (1..).zip(known) {
        let catalogue = Catalogue::up_to(colours, counts.len());
        let generated = (1..=counts.len()).map(|n| catalogue.of_order(n).len());
        assert!(generated.eq(counts.iter().copied()), "{colours} colours");
    }
    let catalogue = Catalogue::up_to(2, 5);
    let oriented: Vec<usize> = (1..=10).map(|n| catalogue.oriented(n).count()).collect();
    assert_eq!(oriented, [1, 1, 3, 8, 27, 91, 350, 1376, 5743, 24635]);
}

#[test]
fn labelled_trees_are_counted_by_cayley() {
    for colours in 1..=3 {
        let catalogue = Catalogue::up_to(colours, 7);
        for n in 1..=7 {
            // n!/σ labellings of each: n^{n−1} rooted trees with labels, and a colour for each edge.
            let colourings = (colours as u64).pow(n as u32 - 1);
            let expected = (n as u64).pow(n as u32 - 1) * colourings;
            let labellings = catalogue.of_order(n).iter().map(|t| factorial(n) / t.symmetry()).sum::<u64>();
            assert_eq!(labellings, expected, "{colours} colours, order {n}");
            // n!/(γ σ) labellings that increase away from the root: (n − 1)! in all.
            let increasing =
                catalogue.of_order(n).iter().map(|t| factorial(n) / (t.symmetry() * t.density())).sum::<u64>();
            assert_eq!(increasing, factorial(n - 1) * colourings, "{colours} colours, order {n}");
        }
    }
}

#[test]
fn symmetries_are_as_counted_by_hand() {
    let catalogue = Catalogue::up_to(2, 5);
    let symmetry =
        |text: &str| catalogue.trees().iter().find(|tree| catalogue.show(tree) == text).expect(text).symmetry();
    assert_eq!([symmetry("[]"), symmetry("[[][]]"), symmetry("[[]'[]]"), symmetry("[[]'[]'[]'[]]")], [1, 2, 1, 6]);
    assert_eq!([symmetry("[[[]][[]]]"), symmetry("[[[]][[]']]")], [2, 1]);
}

#[test]
fn formulas_are_as_on_paper() {
    let catalogue = Catalogue::up_to(2, 5);
    let formulas: Vec<String> = catalogue.of_order(3).iter().map(|tree| formula(&catalogue, tree)).collect();
    let expected =
        "Σ b_i â_ij c_j, Σ b_i a_ij c_j, Σ b_i â_ij ĉ_j, Σ b_i a_ij ĉ_j, Σ b_i ĉ_i^2, Σ b_i c_i ĉ_i, Σ b_i c_i^2";
    assert_eq!(formulas.join(", "), expected);
    assert_eq!(formula(&catalogue, &catalogue.of_order(1)[0]), "Σ b_i");
    assert!(catalogue.of_order(5).iter().any(|tree| formula(&catalogue, tree) == "Σ b_i a_ij c_j â_ik ĉ_k"
        || formula(&catalogue, tree) == "Σ b_i â_ij ĉ_j a_ik c_k"));
}
