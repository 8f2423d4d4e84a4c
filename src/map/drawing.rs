//! A map drawn in letters, for a person to hold against their picture.
//!
//! Row 0 is at the top and `o` is texel (0, 0). A map of one face has the six axes of the world where they
//! land: an axis that fills a whole row or rim stands there several times. A map of several faces
//! shows, for each, what its middle looks at and what lies beyond the middle of each edge, which
//! tells order and orientation at a glance.

use crate::map::Map;
use crate::number::angle;

const AXES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];
const ROWS: usize = 11;
/// A letter is about twice as high as wide.
const SQUARE: usize = 2 * ROWS + 1;
const CELL: (usize, usize) = (11, 3);

/// The drawing, each line ended.
pub fn draw(map: &Map) -> String {
    let mut canvas = if map.face_layout().faces > 1 {
        cells(map)
    } else {
        picture(map)
    };
    canvas.letters[0][0] = 'o';
    let mut text = String::new();
    for row in canvas.letters {
        text.push_str(row.iter().collect::<String>().trim_end());
        text.push('\n');
    }
    text
}

struct Canvas {
    letters: Vec<Vec<char>>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Canvas {
        Canvas {
            letters: vec![vec![' '; width]; height],
        }
    }

    fn frame(&mut self, left: usize, top: usize, right: usize, bottom: usize) {
        for x in left..=right {
            for y in [top, bottom] {
                self.letters[y][x] = if x == left || x == right { '+' } else { '-' };
            }
        }
        for y in top + 1..bottom {
            for x in [left, right] {
                if self.letters[y][x] == ' ' {
                    self.letters[y][x] = '|';
                }
            }
        }
    }

    fn write(&mut self, x: usize, y: usize, text: &str) {
        for (k, letter) in text.chars().enumerate() {
            self.letters[y][x + k] = letter;
        }
    }
}

fn decode(map: &Map, uv: &[f64]) -> [f64; 3] {
    let mut d = [0.0; 3];
    map.decode_numbers(None, uv, &mut d);
    d
}

/// The world axis nearest to a direction.
fn nearest(d: [f64; 3]) -> usize {
    let size = |k: usize| d[k].abs();
    let k = (0..3).fold(0, |best, k| if size(k) > size(best) { k } else { best });
    2 * k + usize::from(d[k] < 0.0)
}

fn along(d: [f64; 3], axis: usize) -> f64 {
    if axis.is_multiple_of(2) {
        d[axis / 2]
    } else {
        -d[axis / 2]
    }
}

fn cells(map: &Map) -> Canvas {
    let face_layout = map.face_layout();
    let (columns, rows) = if face_layout.is_atlas {
        (face_layout.columns, face_layout.rows)
    } else {
        (face_layout.faces, 1)
    };
    let (width, height) = (CELL.0 + 1, CELL.1 + 1);
    let mut canvas = Canvas::new(columns * width + 1, rows * height + 1);
    for place in &face_layout.places[..face_layout.faces] {
        let (column, row) = if face_layout.is_atlas {
            (place.column, place.row)
        } else {
            (place.stored, 0)
        };
        let at = |a: f64, b: f64| {
            if face_layout.is_atlas {
                let u = (column as f64 + a) / columns as f64;
                decode(map, &[u, (row as f64 + b) / rows as f64])
            } else {
                decode(map, &[a, b, place.stored as f64])
            }
        };
        let middle = at(0.5, 0.5);
        // What an edge adds to the middle.
        let beyond = |a: f64, b: f64| {
            let d = at(a, b);
            let dot: f64 = (0..3).map(|k| d[k] * middle[k]).sum();
            if dot.is_nan() {
                "" // not a part of the valid image
            } else {
                AXES[nearest([0, 1, 2].map(|k| d[k] - dot * middle[k]))]
            }
        };
        let (x, y) = (column * width, row * height);
        canvas.frame(x, y, x + width, y + height);
        canvas.write(x + 5, y + 1, beyond(0.5, 0.02));
        canvas.write(x + 1, y + 2, beyond(0.02, 0.5));
        if !middle[0].is_nan() {
            canvas.write(x + 4, y + 2, &format!("({})", AXES[nearest(middle)]));
        }
        canvas.write(x + 10, y + 2, beyond(0.98, 0.5));
        canvas.write(x + 5, y + 3, beyond(0.5, 0.98));
        if !face_layout.is_atlas {
            canvas.letters[y][x] = 'o';
        }
    }
    canvas
}

fn picture(map: &Map) -> Canvas {
    let (across, down) = map.info().aspect;
    let (w, h) = (SQUARE * across / down.max(1), ROWS);
    let place = |i: usize, j: usize| {
        let u = (i as f64 + 0.5) / w as f64;
        decode(map, &[u, (j as f64 + 0.5) / h as f64])
    };
    let seen: Vec<Vec<[f64; 3]>> = (0..h)
        .map(|j| (0..w).map(|i| place(i, j)).collect())
        .collect();
    let valid = |i: isize, j: isize| {
        (0..w as isize).contains(&i)
            && (0..h as isize).contains(&j)
            && !seen[j as usize][i as usize][0].is_nan()
    };
    let mut canvas = Canvas::new(w + 2, h + 2);
    canvas.frame(0, 0, w + 1, h + 1);
    for (j, row) in (0..).zip(&seen) {
        for i in 0..row.len() as isize {
            let inside = |i: isize| (0..w as isize).contains(&i);
            let rim = valid(i, j)
                && [(i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)]
                    .iter()
                    .any(|&(a, b)| inside(a) && (0..h as isize).contains(&b) && !valid(a, b));
            if rim {
                canvas.letters[j as usize + 1][i as usize + 1] = '.';
            }
        }
    }
    for (axis, name) in AXES.iter().enumerate() {
        for (i, j) in landings(map, axis, &seen) {
            canvas.write(i.min(w - 2) + 1, j + 1, name);
        }
    }
    canvas
}

/// The letters where a world axis lands, none beside another.
fn landings(map: &Map, axis: usize, seen: &[Vec<[f64; 3]>]) -> Vec<(usize, usize)> {
    let (w, h) = (seen[0].len(), seen.len());
    let mut direction = [0.0; 3];
    direction[axis / 2] = if axis.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut covered = [false];
    map.covers_numbers(None, &direction, &mut covered);
    if !covered[0] {
        return Vec::new();
    }
    let mut near: Vec<(f64, usize, usize)> = Vec::new();
    for (j, row) in seen.iter().enumerate() {
        for (i, d) in row.iter().enumerate() {
            let angle = angle::acos(along(*d, axis).clamp(-1.0, 1.0));
            // On a rim whose letters lie at different depths all are about as near.
            if angle < 0.6 {
                near.push((angle, i, j));
            }
        }
    }
    let least = near.iter().map(|n| n.0).fold(f64::INFINITY, f64::min);
    near.retain(|n| n.0 <= 1.15 * least + 0.02);
    // The middle of a row first, so that what is placed lies evenly.
    let aside = |i: usize, j: usize| (2 * i + 1).abs_diff(w) + 2 * (2 * j + 1).abs_diff(h);
    near.sort_by(|a, b| {
        let key = |n: &(f64, usize, usize)| ((n.0 * 50.0) as usize, aside(n.1, n.2));
        key(a).cmp(&key(b)).then(a.1.cmp(&b.1))
    });
    let mut placed: Vec<(usize, usize)> = Vec::new();
    for (_, i, j) in near {
        let apart = |&(a, b): &(usize, usize)| a.abs_diff(i) >= w / 4 || b.abs_diff(j) > h / 4;
        if placed.iter().all(apart) {
            placed.push((i, j));
        }
    }
    placed
}
