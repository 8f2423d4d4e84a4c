//! A map in one string: `latlong`, `latlong:blender`, `perspective(fov=60)`, `angular(fov=180):openimageio`.
//!
//! A projection's name, then its parameters, then the program whose convention it is. It is all that a command line can say, and the
//! same string serves wherever a map is named. A number may be a quotient, as an aspect is: `perspective(fov=75, aspect=16/9)`.

use crate::error::Error;

/// The parts of such a string, unchecked but for its form.
pub(super) struct Name<'a> {
    pub(super) kind: &'a str,
    pub(super) parameters: Vec<(&'a str, f64)>,
    pub(super) convention: Option<&'a str>,
}

pub(super) fn parse(text: &str) -> Result<Name<'_>, Error> {
    let Some((kind, rest)) = text.split_once('(') else {
        let (kind, convention) = match text.split_once(':') {
            Some((kind, convention)) => (kind, Some(convention)),
            None => (text, None),
        };
        return Ok(Name {
            kind,
            parameters: Vec::new(),
            convention,
        });
    };
    let wrong = |why: &str| {
        Error::Contradiction(format!(
            "cannot read '{text}': {why}, as in 'perspective(fov=75, aspect=16/9)'"
        ))
    };
    if kind.contains(':') {
        return Err(wrong("parameters stand behind the projection's own name"));
    }
    let (inside, after) = rest
        .split_once(')')
        .ok_or_else(|| wrong("a parenthesis is not closed"))?;
    let convention = match after.strip_prefix(':') {
        None if !after.is_empty() => {
            return Err(wrong("only a colon and a program follow the parameters"));
        }
        convention => convention,
    };
    let given = inside.split(',').map(str::trim).filter(|x| !x.is_empty());
    let parameters: Option<Vec<_>> = given.map(assignment).collect();
    Ok(Name {
        kind: kind.trim_end(),
        parameters: parameters.ok_or_else(|| wrong("a parameter is a name and a number"))?,
        convention,
    })
}

/// "fov=60" or "aspect=16/9".
fn assignment(text: &str) -> Option<(&str, f64)> {
    let (name, value) = text.split_once('=')?;
    let number = |x: &str| x.trim().parse::<f64>().ok();
    let value = match value.split_once('/') {
        Some((over, under)) => number(over)? / number(under)?,
        None => number(value)?,
    };
    Some((name.trim(), value))
}

#[cfg(test)]
mod tests {
    use crate::map::{Map, MapOptions};

    #[test]
    fn what_is_written_is_what_is_meant() {
        let with = |name, parameters| Map::with(name, MapOptions::new().parameters(parameters));
        for (text, name, parameters) in [
            ("perspective(fov=60)", "perspective", &[("fov", 60.0)][..]),
            (
                "dual_fisheye( fov = 2e2 )",
                "dual_fisheye",
                &[("fov", 200.0)],
            ),
            (
                "angular(fov=180):openimageio",
                "angular:openimageio",
                &[("fov", 180.0)],
            ),
            (
                "perspective(fov=75, aspect=16/9)",
                "perspective",
                &[("fov", 75.0), ("aspect", 16.0 / 9.0)],
            ),
            ("latlong()", "latlong", &[]),
        ] {
            assert_eq!(
                Map::new(text).unwrap(),
                with(name, parameters).unwrap(),
                "{text}"
            );
        }
        // A row's own parameter gives way to one that is written.
        let wide = Map::new("angular(fov=200):ffmpeg").unwrap();
        assert_eq!(wide.parameters(), [200.0]);
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (text, why) in [
            (
                "perspective(fow=60)",
                "unknown parameter 'fow'; did you mean 'fov'? 'perspective' has fov, ",
            ),
            (
                "latlong(fov=60)",
                "projection 'latlong' takes no parameters, got `fov`",
            ),
            ("perspective(fov=60", "a parenthesis is not closed"),
            ("perspective(60)", "a parameter is a name and a number"),
            (
                "perspective(fov=wide)",
                "a parameter is a name and a number",
            ),
            ("perspective(fov=60)x", "only a colon and a program follow"),
            (
                "angular:openimageio(fov=180)",
                "parameters stand behind the projection's own name",
            ),
            ("perspective(fov=190)", "`fov` must be"),
            ("angular(fov=180, fov=90)", "`fov` is given twice"),
            ("angular(fov=180):openimagio", "did you mean 'openimageio'?"),
        ] {
            let error = Map::new(text).unwrap_err().to_string();
            assert!(error.contains(why), "{text}: {error}");
        }
        let twice = MapOptions::new().parameters(&[("fov", 90.0)]);
        let error = Map::with("angular(fov=180)", twice)
            .unwrap_err()
            .to_string();
        assert_eq!(error, "`fov` is given twice, 180 and 90");
    }
}
