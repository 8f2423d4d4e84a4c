//! A map in words: where the world's axes land, which way is up, whether it is mirrored.

use crate::geometry::world::World;
use crate::map::Map;
use crate::map::conventions;
use crate::map::drawing::draw;
use crate::map::grid::Grid;
use std::fmt::Write;

const AXES: [(&str, [f64; 3]); 6] = [
    ("+x", [1.0, 0.0, 0.0]),
    ("-x", [-1.0, 0.0, 0.0]),
    ("+y", [0.0, 1.0, 0.0]),
    ("-y", [0.0, -1.0, 0.0]),
    ("+z", [0.0, 0.0, 1.0]),
    ("-z", [0.0, 0.0, -1.0]),
];

impl Map {
    /// The map in words: what it is, where the world's axes land, which way is up, whether it is mirrored, and a drawing.
    ///
    /// ```
    /// use spheremap::Map;
    /// let text = Map::new("latlong:mitsuba")?.explain();
    /// assert!(text.starts_with("projection  latlong: "));
    /// assert!(text.contains("as mitsuba has it"));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn explain(&self) -> String {
        explain(self)
    }
}

fn explain(map: &Map) -> String {
    let info = map.info();
    let mut text = String::new();
    let mut line = |label: &str, value: String| {
        let _ = writeln!(text, "{label:<11} {value}");
    };
    let convention = map
        .convention()
        .map(|name| format!(", as {name} has it"))
        .unwrap_or_default();
    line(
        "projection",
        format!("{}: {}{convention}", info.name, info.title),
    );
    line("", info.summary.to_owned());
    line("source", info.source.to_owned());
    for (parameter, value) in info.parameters.iter().zip(map.parameters()) {
        line(
            "parameter",
            format!(
                "{} = {value} {}, {}",
                parameter.name, parameter.unit, parameter.doc
            ),
        );
    }
    line("axes", axes(map));
    let row = map
        .convention()
        .and_then(|name| conventions::find(info.name, name).ok());
    line("chirality", chirality(map));
    if map.convention().is_some() || map.world() != World::OURS {
        let hand = if map.world().left_handed() {
            ": what is mirrored above is not mirrored there, and the other way round"
        } else {
            ""
        };
        line("world", format!("{}{hand}", map.world().words()));
    }
    line("up", up(map));
    if let Some(layout) = map.layout() {
        line(
            "layout",
            format!("{layout}, {} faces", map.face_layout().faces),
        );
    }
    let grid = match map.grid() {
        Grid::Centers => "texel i is centered at (i + 1/2)/n",
        Grid::Corners => "texel i is centered at i/(n - 1): the outer ones lie on the edges",
        Grid::CornersV => "centers along u; along v row j is at j/(n - 1), on the edges",
    };
    line("grid", format!("{}: {grid}", map.grid().name()));
    let coverage = map.coverage();
    line(
        "coverage",
        format!("{}, {:.6} sr", coverage.name(), coverage.solid_angle()),
    );
    let (low, high) = map.density_range();
    let claims = match (info.equal_area, info.conformal) {
        (true, _) => " (equal-area)",
        (_, true) => " (conformal)",
        _ => "",
    };
    line(
        "density",
        format!("{low:.4} to {high:.4} sr per unit of uv area{claims}"),
    );
    if let Some(pose) = map.pose() {
        let row = |k: usize| {
            let numbers = pose.row(k).to_array().map(|x| format!("{x:+.4}"));
            numbers.join(" ")
        };
        line("turned by", format!("({}; {}; {})", row(0), row(1), row(2)));
    }
    line("singular", info.singular.to_owned());
    for (name, direction) in AXES {
        line(
            if name == "+x" { "lands" } else { "" },
            format!("{name} {}", place(map, direction)),
        );
    }
    if let Some(row) = row {
        line("ahead", row.ahead.to_owned());
        line("note", row.note.to_owned());
        line(
            "known from",
            format!("{} ({}), {}", row.source, row.version, row.verified()),
        );
    }
    text.push_str("As it is stored, row 0 at the top; o is texel (0, 0):\n\n");
    text.push_str(&draw(map));
    text
}

fn axes(map: &Map) -> String {
    let text = map.axes().to_string();
    let mut parts = text.split(' ');
    let mut next = || parts.next().unwrap_or_default().to_owned();
    format!("{} right, {} down, {} forward", next(), next(), next())
}

fn chirality(map: &Map) -> String {
    let world = "as seen from inside a right-handed world";
    let mirrored = map.mirrored();
    match (mirrored.contains(&true), mirrored.contains(&false)) {
        (true, false) => format!("mirrored {world}"),
        (false, _) => format!("not mirrored {world}"),
        (true, true) => {
            let list: Vec<String> = (0..mirrored.len())
                .filter(|face| mirrored[*face])
                .map(|f| f.to_string())
                .collect();
            format!("face {} mirrored {world}, the others not", list.join(", "))
        }
    }
}

fn up(map: &Map) -> String {
    let down = map.axes();
    let (axis, negative) = (down.world[1], down.negative[1]);
    let letter = ['x', 'y', 'z'][axis as usize];
    format!(
        "{}{letter} points up in the picture",
        if negative { '+' } else { '-' }
    )
}

fn place(map: &Map, direction: [f64; 3]) -> String {
    let mut uv = vec![0.0; map.uv_width()];
    map.encode_numbers(None, &direction, &mut uv);
    if uv[0].is_nan() {
        return "outside the coverage".to_owned();
    }
    let face = uv
        .get(2)
        .map(|face| format!(", face {face}"))
        .unwrap_or_default();
    let where_ = words(uv[0], uv[1]);
    format!("(u, v) = ({:.4}, {:.4}){face}, {where_}", uv[0], uv[1])
}

fn words(u: f64, v: f64) -> String {
    let third = |x: f64, names: [&'static str; 3]| match x {
        x if x < 0.02 => format!("{} edge", names[0]),
        x if x < 0.48 => names[0].to_owned(),
        x if x <= 0.52 => "middle".to_owned(),
        x if x <= 0.98 => names[2].to_owned(),
        _ => format!("{} edge", names[2]),
    };
    let (across, down) = (
        third(u, ["left", "", "right"]),
        third(v, ["top", "", "bottom"]),
    );
    match (across.as_str(), down.as_str()) {
        ("middle", "middle") => "center".to_owned(),
        ("middle", _) => down,
        (_, "middle") => across,
        _ => format!("{down}, {across}"),
    }
}
