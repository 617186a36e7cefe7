//! Time stamps that programs write before what they log.

/// The line behind a time stamp at its front; the whole line if there is none.
///
/// A stamp is a time `12:00:01`, perhaps with a fraction, a date before it or brackets around it, that ends with a space,
/// a colon or its bracket; or seconds `1763752806.123`. Octets between colons in groups of three, the first of which
/// happens to be a time, are octets, and so is a time alone.
pub(super) fn behind(line: &str) -> &str {
    if let Some((seconds, rest)) = line.split_once([' ', '\t'])
        && is_seconds(seconds)
    {
        return rest.trim_start();
    }
    let open = line.strip_prefix(['[', '(']);
    let stamped = without_date(open.unwrap_or(line));
    let Some((rest, fraction)) = without_time(stamped) else { return line };
    let rest = without_zone(rest);
    if open.is_some() {
        return rest.strip_prefix([']', ')']).map_or(line, |rest| rest.trim_start_matches(':').trim_start());
    }
    if rest.is_empty() && fraction {
        return rest;
    }
    if let Some(rest) = rest.strip_prefix(": ") {
        return rest.trim_start();
    }
    let Some(rest) = rest.strip_prefix([' ', '\t']).map(str::trim_start) else { return line };
    if rest.is_empty() || begins_with_group(rest) { line } else { rest }
}

/// Whether two or three octets between colons are at the front.
fn begins_with_group(text: &str) -> bool {
    let next = text.split(char::is_whitespace).next().unwrap_or_default();
    let is_octet = |part: &str| part.len() == 2 && part.bytes().all(|digit| digit.is_ascii_hexdigit());
    matches!(next.split(':').count(), 2 | 3) && next.split(':').all(is_octet)
}

/// `0.001234`, but not `10.05`, which may be two octets.
fn is_seconds(text: &str) -> bool {
    text.split_once('.')
        .is_some_and(|(whole, fraction)| is_decimal(whole) && is_decimal(fraction) && fraction.len() > 2)
}

/// Without `2026-11-21`, `21.11.2026` or `Nov 21` and the space or `T` behind it.
fn without_date(text: &str) -> &str {
    let Some((first, rest)) = text.split_once([' ', 'T']) else { return text };
    let parts = |mark| {
        let mut parts = first.split(mark);
        let all = [parts.next(), parts.next(), parts.next()];
        let is_part =
            |part: Option<&str>| part.is_some_and(|part| is_decimal(part) && (1..=4).contains(&part.len()));
        parts.next().is_none() && all.into_iter().all(is_part)
    };
    if ['-', '.', '/'].into_iter().any(parts) {
        return rest.trim_start();
    }
    if MONTHS.contains(&first)
        && let Some((day, rest)) = rest.trim_start().split_once(' ')
        && is_decimal(day)
    {
        return rest.trim_start();
    }
    text
}

const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// What is behind `12:00:01` or `12:00:01.123`, and whether there was a fraction.
fn without_time(text: &str) -> Option<(&str, bool)> {
    let (hours, rest) = text.split_once(':')?;
    let (minutes, rest) = rest.split_once(':')?;
    let (seconds, rest) = rest.split_at_checked(2)?;
    let below = |text: &str, limit: u8| {
        is_decimal(text) && text.len() <= 2 && text.parse().is_ok_and(|number: u8| number < limit)
    };
    // A minute may have a leap second.
    let is_time = below(hours, 24) && below(minutes, 60) && minutes.len() == 2 && below(seconds, 61);
    if !is_time {
        return None;
    }
    let Some(fraction) = rest.strip_prefix(['.', ',']) else { return Some((rest, false)) };
    let end = fraction.find(|char: char| !char.is_ascii_digit()).unwrap_or(fraction.len());
    let (digits, behind) = fraction.split_at_checked(end)?;
    if digits.is_empty() { Some((rest, false)) } else { Some((behind, true)) }
}

/// Without `Z` or `+01:00`.
fn without_zone(text: &str) -> &str {
    if let Some(rest) = text.strip_prefix('Z') {
        return rest;
    }
    let Some(zone) = text.strip_prefix(['+', '-']) else { return text };
    let end = zone.find(|char: char| !char.is_ascii_digit() && char != ':').unwrap_or(zone.len());
    zone.get(end..).filter(|_| matches!(end, 2 | 4 | 5)).unwrap_or(text)
}

fn is_decimal(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_logs_write_before_a_line_is_no_octets() {
        for stamp in [
            "12:00:01",
            "9:05:00",
            "12:00:01.123",
            "12:00:01,123456",
            "[12:00:01.123]",
            "(12:00:01)",
            "[12:00:01]:",
            "12:00:01:",
            "2026-11-21 12:00:01",
            "2026-11-21T12:00:01.123Z",
            "2026-11-21T12:00:01+01:00",
            "[2026-11-21 12:00:01.5]",
            "21.11.2026 12:00:01",
            "2026/11/21 12:00:01",
            "Nov 21 12:00:01",
            "Nov  1 12:00:01",
            "1763752806.123",
            "0.001234",
        ] {
            for rest in ["10 05 02", "TX: 10 05 02", "TX:10", "TX 100502", "10:05:02:49:50:16"] {
                assert_eq!(behind(&std::format!("{stamp} {rest}")), rest, "{stamp}");
            }
        }
        assert_eq!(behind("[12:00:01]10 05"), "10 05");
        assert_eq!(behind("12:00:01.123"), "");
    }

    #[test]
    fn octets_between_colons_stay() {
        for line in [
            "10:05:02:49:50:16",
            "10:05:02",
            "10:05:02 49:50:16",
            "[10:05:02:49:50:16]",
            "68:05:05:68 85",
            "E5",
            "10-05-02 49 50 16",
            "10.05 02.49",
            "",
        ] {
            assert_eq!(behind(line), line);
        }
    }

    #[test]
    fn what_is_no_time_stays() {
        for time in
            ["24:00:01", "12:60:01", "12:00:61", "12:5:01", "012:00:01", "+1:00:01", "1x:00:01", ":00:01"]
        {
            let line = std::format!("{time} TX: E5");
            assert_eq!(behind(&line), line);
        }
        assert_eq!(behind("23:59:60 TX: E5"), "TX: E5", "a leap second");
    }
}
