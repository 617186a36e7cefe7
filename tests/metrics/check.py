"""Reads metrics with the parser of prometheus_client, which raises on what OpenMetrics does not allow.

    check.py URL LINK
"""

import sys
import urllib.request
from concurrent.futures import ThreadPoolExecutor

from prometheus_client.openmetrics.parser import text_string_to_metric_families

MEDIA_TYPE = "application/openmetrics-text; version=1.0.0; charset=utf-8"
READERS = 50

url, link = sys.argv[1:]


def scrape(_=None):
    """The families by name."""
    with urllib.request.urlopen(url, timeout=10) as answer:
        assert answer.headers["content-type"] == MEDIA_TYPE, answer.headers["content-type"]
        text = answer.read().decode()
    assert text.endswith("# EOF\n")
    families = {family.name: family for family in text_string_to_metric_families(text)}
    assert len(families) == text.count("# TYPE "), "a family is told twice"
    return families


families = scrape()
types = {family.type for family in families.values()}
assert types == {"counter", "gauge", "histogram", "info"}, types
for name, family in families.items():
    assert name.startswith("profidrive_") or name == "process_start_time_seconds", name
    assert family.documentation.endswith("."), f"{name}: {family.documentation}"
    assert name.endswith("_seconds") == (family.unit == "seconds"), f"{name} in {family.unit!r}"
    for sample in family.samples:
        assert family.type == "gauge" or sample.value >= 0, sample
links = {sample.labels["link"] for sample in families["profidrive_line"].samples}
assert link in links, f"expected {link!r} among {links}"
models = {sample.labels["model"] for sample in families["profidrive_station"].samples}
assert models == {"ag03-1", "Remote I/O", "profile", "ap10", "asda-a2"}, models
states = families["profidrive_drive_state"].samples
drives = {(sample.labels["line"], sample.labels["address"]) for sample in states}
assert sum(sample.value for sample in states) == len(drives) == 4, states

# Many at once: each gets the whole text.
with ThreadPoolExecutor(READERS) as readers:
    for others in readers.map(scrape, range(READERS)):
        assert others.keys() == families.keys()
print(f"metrics: {len(families)} families, {sum(len(f.samples) for f in families.values())} series, read by {READERS} at once")
