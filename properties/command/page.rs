//! Properties of `report`: the page of a campaign.

use super::probe::not_run;
use super::{FAULT, LAW, directory, has_all, refuses_each, run, stdout, system, typed};
use euler_poincare::laws;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Elements without an end.
const VOID: [&str; 7] = ["meta", "br", "hr", "img", "input", "link", "wbr"];

/// The names of a tag's attributes, each of which it may have once.
fn attributes(tag: &str) -> BTreeSet<&str> {
    let (mut names, mut rest) = (BTreeSet::new(), tag.split_once(' ').map_or("", |(_, rest)| rest).trim());
    while !rest.is_empty() {
        let (name, after) = rest.split_at(rest.find(['=', ' ']).unwrap_or(rest.len()));
        assert!(names.insert(name), "two attributes {name}: <{tag}>");
        rest = match after.strip_prefix("=\"") {
            Some(value) => value.split_once('"').unwrap_or_else(|| panic!("<{tag}>")).1.trim_start(),
            None => after.trim_start(),
        };
    }
    names
}

/// Whether every element ends where it must and has no attribute twice; the names of all elements and the text between them.
fn parsed(page: &str) -> (BTreeSet<String>, String) {
    let (mut open, mut names, mut text) = (Vec::<String>::new(), BTreeSet::new(), String::new());
    let mut rest = page.strip_prefix("<!DOCTYPE html>").unwrap_or(page);
    while let Some(at) = rest.find('<') {
        text.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        // A ">" within quotes does not end the tag.
        let mut quoted = false;
        let end = rest.find(|c| {
            quoted ^= c == '"';
            c == '>' && !quoted
        });
        let (tag, after) = rest.split_at(end.expect("a tag ends"));
        rest = &after[1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name), "before {:.60}", rest);
            continue;
        }
        let name = tag.split_ascii_whitespace().next().expect("a name").to_owned();
        assert!(name.bytes().all(|b| b.is_ascii_alphanumeric()), "<{tag}>");
        names.insert(name.clone());
        let (tag, whole) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
        attributes(tag);
        if name == "style" || name == "script" {
            rest = rest.split_once(&format!("</{name}>")).expect("it ends").1;
        } else if !whole && !VOID.contains(&name.as_str()) {
            open.push(name);
        }
    }
    text.push_str(rest);
    assert_eq!(open, [""; 0], "all elements end");
    (names, text)
}

/// The sections of a campaign's page.
const SECTIONS: [&str; 6] = ["verdicts", "undecided", "coverage", "orders", "faults", "failures"];

/// What holds for every page of a campaign; its text.
fn sound(page: &str) -> String {
    assert_eq!(page.matches("<script").count(), 1, "one script, its own");
    assert!(page.contains("default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-"));
    complete(page, &SECTIONS)
}

/// What holds for every page: it needs nothing from elsewhere, and has these sections; its text.
pub fn complete(page: &str, sections: &[&str]) -> String {
    let (names, text) = parsed(page);
    for name in ["iframe", "img", "link", "object"] {
        assert!(!names.contains(name), "<{name}>");
    }
    for link in page.split("href=\"").skip(1) {
        let target = link.split_once('"').unwrap().0.strip_prefix('#').expect("no link leads away");
        assert_eq!(page.matches(&format!(" id=\"{target}\"")).count(), 1, "{target}");
    }
    for outside in ["http:", "https:", "//www", "url(", "@import"] {
        assert!(!page.contains(outside), "{outside}");
    }
    for section in sections {
        assert_eq!(page.matches(&format!("<section id=\"{section}\"")).count(), 1, "{section}");
        assert!(page.contains(&format!("href=\"#{section}\"")), "{section}");
    }
    text
}

/// A campaign that no program ran: its laws with their numbers of cases, and the text of its results.
fn made_up(here: &Path, laws: &[(&str, usize)], results: Option<&str>) -> PathBuf {
    let campaign = here.join("campaign");
    fs::create_dir_all(&campaign).unwrap();
    let laws: Vec<_> =
        laws.iter().map(|(name, cases)| serde_json::json!({ "name": name, "cost": "cheap", "cases": cases })).collect();
    let manifest = serde_json::json!({
        "version": "0.0.1", "binary": "0123456789abcdef0123", "seed": 5, "cases": 4, "laws": laws, "plant": null, "shard": null,
    });
    fs::write(campaign.join("campaign.json"), manifest.to_string()).unwrap();
    if let Some(results) = results {
        fs::write(campaign.join("results.jsonl"), results).unwrap();
    }
    campaign
}

fn held(law: &str, index: usize, defect: f64) -> String {
    let labels = r#"{"algebra":"so3","dimension":"3","force":"constant+periodic"}"#;
    format!(
        r#"{{"law":"{law}","index":{index},"verdict":"holds","defect":{defect:?},"bound":256.0,"labels":{labels}}}"#
    ) + "\n"
}

/// The page of the campaign in `here`.
fn page(here: &Path) -> String {
    run(here, &["report", "campaign"]).ends(0).prints("report.html");
    fs::read_to_string(here.join("campaign/report.html")).unwrap()
}

#[test]
fn a_campaign_has_a_page_with_a_row_for_every_law() {
    let here = directory("page");
    typed(&here, "verify --laws retraction-*,plain-step --cases 30 --seed 3 --out campaign").ends(0);
    typed(&here, &format!("verify --faults --laws {LAW} --seed 3 --out campaign")).ends(0);
    let first = page(&here);
    let text = sound(&first);
    let judged: Vec<_> = laws::all().into_iter().filter(|law| law.about.name.starts_with("retraction-")).collect();
    assert!(judged.len() >= 5);
    for law in judged {
        assert_eq!(first.matches(&format!("id=\"law-{}\"", law.about.name)).count(), 1, "{}", law.about.name);
        assert!(first.contains(&format!("href=\"#law-{}\"", law.about.name)), "{}", law.about.name);
        assert!(text.contains(law.about.source), "{}", law.about.source);
    }
    let others = "Known to the laws of this campaign and not tried";
    has_all(&text, &format!("Nothing is broken: every law holds on every one of ¦ each was caught ¦ {others}"));
    // A long list is folded, and there is nothing to warn of.
    has_all(&first, &format!("{FAULT} ¦ <details class=\"flag\"><summary>"));
    assert!(!first.contains("class=\"notes\""));
    assert_eq!(page(&here), first, "the same campaign, the same page");

    let output = run(&here, &["report", "campaign", "--output", "-", "--plots", "0"]);
    assert_eq!(stdout(&output), first, "no law of orders is here");
    run(&here, &["report", "campaign", "--output", "elsewhere.html"]).ends(0);
    assert_eq!(fs::read_to_string(here.join("elsewhere.html")).unwrap(), first);
}

#[test]
fn a_broken_case_is_shown_with_its_numbers_and_how_to_see_it_again() {
    let here = directory("page-broken");
    typed(&here, &format!("verify --laws {LAW} --cases 20 --plant {FAULT} --out campaign")).ends(1);
    let page = page(&here);
    let text = sound(&page);
    has_all(&text, &format!("One law is broken, {LAW}, on ¦ what is broken was meant to break"));
    let command = text.lines().find_map(|line| line.split_once("euler-poincare replay failures/")).unwrap().1;
    let file = format!("failures/{}.json", command.split_once(".json").unwrap().0);
    run(&here.join("campaign"), &["replay", &file]).ends(1);
    // One row for each arithmetic.
    let details = page.split_once("<details class=\"failure\">").unwrap().1;
    let rows = |digits: &str| details.matches(&format!("<th scope=\"row\">{digits}</th>")).count();
    assert_eq!((rows("16"), rows("32")), (1, 1));

    // A file that is none, and one of a law that is not there.
    fs::write(here.join("campaign/failures/half.json"), "{\"law\":").unwrap();
    let saved = fs::read_to_string(here.join("campaign").join(&file)).unwrap();
    fs::write(here.join("campaign/failures/other.json"), saved.replace(LAW, "no-such-law")).unwrap();
    let said = "failures/half.json cannot be replayed:  ¦ this program has no law &quot;no-such-law&quot;";
    has_all(&sound(&self::page(&here)), said);
}

#[test]
fn errors_against_steps_are_drawn_of_cases_drawn_again() {
    let here = directory("page-orders");
    const ORDER: &str = "order-momentum-attitude";
    // Three cases are shown; a case may leave the domain of its retraction, and then has no errors.
    // The bound tells the page which laws are of orders.
    let row = |index: usize| held(ORDER, index, 0.125).replace("256.0", "0.25");
    made_up(&here, &[(ORDER, 3)], Some(&(0..3).map(row).collect::<String>()));
    let page = page(&here);
    let text = sound(&page);
    has_all(&page, "<svg class=\"order\" ¦ class=\"predicted\" ¦ <circle class=\"asymptotic\"");
    // The symbols of the legends have the colours of their curves.
    has_all(&page, "<svg class=\"key series-0\" ¦ <svg class=\"key series-1\"");
    let case = "case 0 of order-momentum-attitude";
    has_all(&text, &format!("momentum: slope ¦ predicted ¦ {case} ¦ it is not the program that ran the campaign"));
    let none = run(&here, &["report", "campaign", "--plots", "0", "--output", "-"]);
    assert!(!stdout(&none).contains("class=\"order\""));
}

#[test]
fn text_is_escaped() {
    let here = directory("page-escaped");
    let evil = r#"<script>alert('x')</script>&amp;"#;
    let line = |index: usize, rest: &str| format!(r#"{{"law":"{evil}","index":{index},{rest}}}"#) + "\n";
    let results = [
        line(0, &format!(r#""verdict":"broken","defect":null,"bound":1.0,"witness":"{evil}""#)),
        line(1, &format!(r#""verdict":"inconclusive","why":"{evil}","labels":{{"{evil}":"{evil}"}}"#)),
        line(2, &format!(r#""verdict":"not applicable","why":"{evil}","rejections":{{"{evil}":3}}"#)),
    ];
    let campaign = made_up(&here, &[(evil, 3)], Some(&results.concat()));
    fs::write(
        campaign.join("faults.jsonl"),
        format!(r#"{{"law":"{evil}","fault":"{evil}","caught_after":null}}"#) + "\n",
    )
    .unwrap();
    fs::create_dir(campaign.join("failures")).unwrap();
    fs::write(campaign.join("failures/<b>.json"), evil).unwrap();
    let page = page(&here);
    let text = sound(&page);
    assert!(page.matches("<script").count() == 1 && !page.contains("<b>.json"));
    assert!(text.matches("&lt;script&gt;alert('x')&lt;/script&gt;&amp;amp;").count() >= 9, "{text}");
    assert!(text.contains("1 missed") && text.contains("∞"));
}

#[test]
fn what_is_not_there_or_damaged_is_said() {
    let here = directory("page-incomplete");
    let planned = [(LAW, 4), ("no-such-law", 2)];
    made_up(&here, &planned, None);
    has_all(
        &sound(&page(&here)),
        "No case has been judged; 6 of 6 cases are missing. ¦ There are no results ¦ verify --faults --out DIR ¦ \
         Laws that this program does not know: no-such-law. ¦ The campaign was run by another program (version 0.0.1",
    );

    let results = [
        held(LAW, 0, 1.0),
        held(LAW, 0, 2.0),
        "no JSON\n".to_owned(),
        held("another-law", 0, 1.0),
        held(LAW, 4, 1.0),
        "\n".to_owned(),
        held(LAW, 2, 0.0),
        held(LAW, 3, 1.0).trim_end().to_owned(),
    ];
    made_up(&here, &planned, Some(&results.concat()));
    let text = sound(&page(&here));
    // Families without a case are flagged; forces are counted one by one.
    has_all(
        &text,
        "Nothing is broken: every law holds on every one of the 2 cases that could be judged; 4 of 6 cases are missing. ¦ \
         3 lines cannot be used and are left out: ¦ line 3:  ¦ line 4: the campaign has no law &quot;another-law&quot; ¦ \
         line 5: case 4 of retraction-adjoint is none of this campaign ¦ 1 line of cases that were there already ¦ \
         ends within a line ¦ 2 missing ¦ families without a judged case ¦ dimension 8 ¦ force metriplectic",
    );
    assert!(!text.contains("force periodic,"), "{text}");
}

#[test]
fn what_is_no_campaign_is_refused() {
    let here = directory("page-refused");
    fs::create_dir(here.join("empty")).unwrap();
    fs::write(here.join("file"), "").unwrap();
    for (name, manifest) in [("text", "no JSON"), ("part", "{\"seed\": 1}")] {
        fs::create_dir(here.join(name)).unwrap();
        fs::write(here.join(name).join("campaign.json"), manifest).unwrap();
    }
    made_up(&here, &[(LAW, 4)], Some("no JSON\n"));
    refuses_each(&here, include_str!("refused/report.txt"), 8);
}

#[test]
fn a_large_campaign_makes_a_small_page() {
    let here = directory("page-large");
    const CASES: usize = 100_000;
    let results: String = (0..CASES).map(|index| held(LAW, index, index as f64 / 400.0)).collect();
    made_up(&here, &[(LAW, CASES)], Some(&results));
    let page = page(&here);
    sound(&page);
    assert!(page.len() < 100_000, "{} bytes", page.len());
}

/// Whether a typeset sentence is what was written, without a mark that is not set.
fn typeset(html: &str, text: &str) {
    let (_, shown) = parsed(html);
    let shown = shown.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&");
    let unmarked = |text: &str| text.replace(['_', '^', '{', '}', '`'], "");
    assert_eq!(unmarked(&shown), unmarked(text), "{html}");
    // What stands between backquotes is a name of the program.
    let outside = html.split("<code>").map(|part| part.split_once("</code>").map_or(part, |(_, rest)| rest));
    assert!(!outside.collect::<String>().contains(['_', '^', '`']), "{html}");
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    text.split_once(start).unwrap_or_else(|| panic!("{start}: {text:.200}")).1.split_once(end).unwrap().0
}

#[test]
fn the_formulas_of_every_law_and_fault_are_set() {
    let here = directory("page-formulas");
    let all = laws::all();
    let names: Vec<_> = all.iter().map(|law| (law.about.name, 1)).collect();
    let campaign = made_up(&here, &names, Some(""));
    let faults: Vec<_> = all.iter().flat_map(|law| law.about.faults.iter().map(move |fault| (law, fault))).collect();
    let row = |law: &str, fault: &str| format!(r#"{{"law":"{law}","fault":"{fault}","caught_after":1}}"#) + "\n";
    let rows: String = faults.iter().map(|(law, fault)| row(law.about.name, fault.name)).collect();
    fs::write(campaign.join("faults.jsonl"), rows).unwrap();
    let page = page(&here);
    sound(&page);
    for law in &all {
        let row = between(&page, &format!(" id=\"law-{}\"", law.about.name), "</tr>");
        assert_eq!(between(row, "<span class=\"law\">", "</span>").matches(law.about.name).count(), 2, "{row}");
        typeset(between(row, "<span class=\"statement\">", "</span>"), law.about.statement);
        typeset(between(row, "<span class=\"source\">", "</span>"), law.about.source);
        typeset(between(row, "<b>Oracle: </b>", "</p>"), law.about.oracle);
        typeset(between(row, "<b>Bound: </b>", "</p>"), law.about.bound);
    }
    let section = between(&page, "<section id=\"faults\"", "</section>");
    let mut rows = section.split("<tr class=\"\">").skip(1);
    for (_, fault) in faults {
        let row = rows.next().expect("a row for each fault");
        assert!(row.contains(&format!("<td>{}</td>", fault.name)), "names are as they are: {row}");
        let mut cells = row.split("<td class=\"text\">").skip(1).map(|cell| cell.split_once("</td>").unwrap().0);
        typeset(cells.next().unwrap(), fault.what);
        typeset(cells.next().unwrap(), fault.visible_on);
    }
    // What is raised, lowered and dotted, as it is meant.
    let (names, equations) = ("dτ<sub>ξ</sub>⁻¹ ¦ Ad<sub>τ(ξ)</sub>", "Φ'(μ) ¦ μ̇ ¦ ad*<sub>η</sub>");
    has_all(&page, &format!("{names} ¦ −C<sup>d</sup><sub>ab</sub> μ<sub>d</sub> ¦ {equations}"));
}

#[test]
fn broken_laws_are_first_and_the_others_keep_their_order() {
    let here = directory("page-ordered");
    let names = ["retraction-tangent", "retraction-inverse", "retraction-adjoint", "retraction-logarithm"];
    let broken = |law: &str, defect: f64| held(law, 0, defect).replace("\"holds\"", "\"broken\",\"witness\":\"w\"");
    let results = [held(names[0], 0, 1.0), held(names[1], 0, 9.0), broken(names[2], 300.0), broken(names[3], 500.0)];
    made_up(&here, &names.map(|name| (name, 1)), Some(&results.concat()));
    let page = page(&here);
    sound(&page);
    let places = [3, 2, 0, 1].map(|k: usize| page.find(&format!(" id=\"law-{}\"", names[k])).unwrap());
    assert!(places.is_sorted(), "{places:?}");
}

/// Chromium's document after its scripts, if it is there and answers.
fn browse(here: &Path, document: &str) -> Result<String, &'static str> {
    fs::write(here.join("frame.html"), document).unwrap();
    let out = fs::File::create(here.join("dom.html")).unwrap();
    let address = format!("file://{}", here.join("frame.html").display());
    let profile = format!("--user-data-dir={}", here.join("profile").display());
    let flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--dump-dom"];
    let quiet = ["--disable-background-networking", "--disable-component-update", "--disable-sync"];
    let start = |name: &&str| {
        let mut command = Command::new(name);
        command.args(flags).args(quiet).args([&profile, &address]).stdin(Stdio::null()).stderr(Stdio::null());
        command.stdout(out.try_clone().unwrap()).spawn().ok()
    };
    let mut child =
        ["chromium", "chromium-browser", "google-chrome"].iter().find_map(start).ok_or("there is no Chromium")?;
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            child.wait().unwrap();
            return Err("Chromium does not answer");
        }
        sleep(Duration::from_millis(100));
    }
    Ok(fs::read_to_string(here.join("dom.html")).unwrap())
}

/// What a script finds in the page, in a frame of this width; `None`, and a word about it, without a browser.
fn asked(here: &Path, page: &str, width: u32, script: &str, test: &str) -> Option<String> {
    // Other scripts are not allowed within the page: the frame around it looks.
    let quoted = page.replace('&', "&amp;").replace('"', "&quot;");
    let frame = format!(
        "<!DOCTYPE html><iframe id=\"f\" style=\"border:0;width:{width}px;height:800px\" srcdoc=\"{quoted}\"></iframe>\
         <script>const ask = (page) => {{ {script} }};\
         f.onload = () => {{ document.body.dataset.found = ask(f.contentDocument); }}</script>"
    );
    match browse(here, &frame) {
        Ok(dom) => Some(between(&dom, "data-found=\"", "\"").to_owned()),
        Err(why) => {
            not_run(test, why);
            None
        }
    }
}

#[test]
fn the_script_filters_and_orders_the_laws() {
    let here = directory("page-script");
    let names = ["retraction-tangent", "retraction-inverse", "retraction-adjoint"];
    let undecided = format!(r#"{{"law":"{}","index":1,"verdict":"inconclusive","why":"w"}}"#, names[0]) + "\n";
    let results = [held(names[0], 0, 1.0), undecided, held(names[1], 0, 9.0), held(names[2], 0, 5.0)];
    made_up(&here, &names.map(|name| (name, 2)), Some(&results.concat()));
    let script = "const get = (id) => page.getElementById(id), found = []; \
        const shown = () => found.push(Array.from(page.querySelectorAll('.verdicts tbody tr')) \
            .filter((row) => row.offsetParent).map((row) => row.dataset.name.replace('retraction-', '')).join('+')); \
        const order = (key) => { get('order').value = key; get('order').dispatchEvent(new Event('change')); shown(); }; \
        const filter = (text) => { get('filter').value = text; get('filter').dispatchEvent(new Event('input')); shown(); }; \
        shown(); ['name', 'ratio', 'inconclusive', 'place'].forEach(order); \
        page.querySelector('th[data-key=ratio] button').click(); shown(); \
        ['dual numbers', 'Ad', 'dτξ−1', 'no such law', ''].forEach(filter); \
        return [get('tools').hidden, get('shown').textContent, get('no-law').hidden].concat(found).join('/');";
    let name = "the_script_filters_and_orders_the_laws";
    let Some(found) = asked(&here, &page(&here), 1280, script, name) else { return };
    let expected = "false/3 of 3/true/tangent+inverse+adjoint/adjoint+inverse+tangent/inverse+adjoint+tangent/\
        tangent+inverse+adjoint/tangent+inverse+adjoint/inverse+adjoint+tangent/tangent/adjoint/adjoint//inverse+adjoint+tangent";
    assert_eq!(found, expected);
}

#[test]
fn no_page_is_wider_than_a_phone() {
    let here = directory("page-width");
    typed(&here, &format!("verify --laws retraction-* --cases 10 --plant {FAULT} --out campaign")).ends(1);
    fits(&here, &page(&here), "no_page_is_wider_than_a_phone");
}

/// Whether a page with everything open is as wide as a phone and as a screen, if there is a browser to tell.
pub fn fits(here: &Path, page: &str, test: &str) {
    let opened = page.replace("<details open", "<details").replace("<details", "<details open");
    let script = "const d = page.documentElement; return d.scrollWidth + '/' + d.clientWidth + '/' + d.scrollHeight;";
    for width in [390, 1280] {
        let Some(found) = asked(here, &opened, width, script, test) else { return };
        let sizes: Vec<u32> = found.split('/').map(|size| size.parse().unwrap()).collect();
        assert!(sizes[0] <= width && sizes[1] > width - 40 && sizes[2] > 1000, "{width}: {found}");
    }
}

/// What holds for every figure; the texts in it.
pub fn drawn(svg: &str) -> String {
    let (names, text) = parsed(svg.trim_end());
    assert!(names.contains("title") && !names.contains("style"), "{names:?}");
    let width: f64 = between(svg, "<svg width=\"", "\"").parse().unwrap();
    let canvas: f64 = between(svg, "viewBox=\"0 0 ", " ").parse().unwrap();
    let title = between(svg, "<text ", "</text>");
    assert!(title.starts_with(&format!("x=\"{}\"", canvas / 2.0)), "{title}");
    has_all(title, "text-anchor=\"middle\"");
    assert!(title.trim_end().ends_with(between(svg, "<title>", "</title>")), "{title}");
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    // Coordinates are whole numbers; those of a canvas that is so much larger make smooth lines.
    let pixel = (canvas / width) as u32;
    assert!(pixel >= 10, "{pixel}");
    let lines = svg.split("<polyline ").skip(1).map(|line| between(line, "points=\"", "\""));
    let coordinates: Vec<u32> = lines.flat_map(|line| line.split([' ', ',']).filter_map(|n| n.parse().ok())).collect();
    assert!(coordinates.iter().any(|coordinate| coordinate % pixel != 0), "lines of whole pixels are wiggly");
    text
}

/// The figure of a run of three steps of the algebra called `name`, of this dimension.
fn run_drawn(here: &Path, name: &str, dimension: usize) -> String {
    let (ones, halves) = (vec!["1"; dimension - 1].join(", "), vec!["\"1/2\""; dimension].join(", "));
    let (inertia, state) = (format!("inertia = [2, {ones}]"), format!("velocity = [{halves}]"));
    let method = "tableau = \"gauss-2\"\nretraction = \"cayley\"";
    let text = system(name, &inertia, method, &state, "step = \"1/4\"\nsteps = 3");
    fs::write(here.join("s.toml"), text).unwrap();
    run(here, &["integrate", "s.toml", "--out", "s.csv", "--plot", "s.svg"]).ends(0);
    fs::read_to_string(here.join("s.svg")).unwrap()
}

#[test]
fn the_figure_of_a_run_has_a_title_and_the_attitude() {
    let here = directory("figure-run");
    let panels = "angular momentum ¦ angular velocity ¦ energy ¦ Casimirs ¦ change since the start";
    let so3 = "s.toml: so3, gauss-2, cayley, h = 1/4 ¦ attitude: unit quaternion ¦ q₀ ¦ q₃ ¦ μ₃ ¦ η₃";
    let se3 = "linear momentum ¦ linear velocity ¦ attitude: unit quaternion ¦ position ¦ x₃ ¦ μ₆ ¦ η₆";
    // The algebra and its dimension, what is in the figure, and what is not.
    for (name, dimension, parts, others) in [
        ("so3", 3, &*format!("{panels} ¦ {so3}"), &["potential", "linear"][..]),
        ("se3", 6, &format!("{panels} ¦ {se3}"), &[]),
        ("so3+r2", 5, "angular momentum of so3 ¦ momentum of r2 ¦ velocity of r2", &[]),
        // The entries of the last row are constant.
        ("se2", 3, "attitude: matrix entries that change ¦ g₁₃", &["g₃₁"]),
        ("so4", 6, "attitude: 10 of 16 entries that change", &[]),
    ] {
        let text = drawn(&run_drawn(&here, name, dimension));
        has_all(&text, parts);
        assert!(!others.iter().any(|other| text.contains(other)), "{name}: {text}");
    }
}
