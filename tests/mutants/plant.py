"""Plants mistakes in a copy of the sources: each is off until its number is in the environment.

A mistake is one small change of an expression or a statement, in code that is no test. All mistakes of a sample are
compiled into one build, each behind `crate::planted::on(NUMBER)`.
"""
import dataclasses
import json
import pathlib
import random
import re
import shutil
import subprocess

import tree_sitter
import tree_sitter_rust

LANGUAGE = tree_sitter.Language(tree_sitter_rust.language())

# The folders that a sample draws from, each with its share of a sample of 400.
SHARES = {
    "src/devices": 60,
    "src/host": 45,
    "src/judge": 50,
    "src/command": 45,
    "src/profibus": 45,
    "src/panel": 35,
    "src/can_bus": 45,
    "src/gsd": 35,
    "elsewhere": 40,
}

SWAPS = {
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&",
    "+": "-", "-": "+", "*": "/", "/": "*", "%": "/", "<<": ">>", ">>": "<<", "&": "|", "|": "&", "^": "&",
}  # fmt: skip
CALLS = {"min": "max", "max": "min", "any": "all", "all": "any", "is_some": "is_none", "is_none": "is_some",
         "take_while": "skip_while", "skip_while": "take_while", "first": "last", "last": "first"}  # fmt: skip
# Of ten sites of a table nine are numbers: they get no more than this part of a sample.
NUMBERS_AT_MOST = 0.15

FOR_TESTS = r"cfg\((?:all\()?test\b"
TEST_MODULE = re.compile(rf"#\[{FOR_TESTS}[^\]]*\]\s*(?:#\[[^\]]*\]\s*)*(?:pub(?:\([a-z]+\))?\s+)?mod (\w+);")

# What a function of this type gives when its body is left out.
EMPTY = {"bool": "return true;", "String": "return String::new();", None: "return;"}

PLANTED = '''// Which planted mistake is on: the number in PROFIDRIVE_PLANTED. Made by tests/mutants.
use std::io::Write as _;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

static ON: OnceLock<u32> = OnceLock::new();
static SEEN: [AtomicBool; COUNT + 1] = [const { AtomicBool::new(false) }; COUNT + 1];

/// Whether the mistake of this number is on. Tells the file of PROFIDRIVE_PLANTED_SEEN that it was asked for.
#[inline(never)]
pub(crate) fn on(number: u32) -> bool {
    if !SEEN[number as usize].swap(true, Ordering::Relaxed)
        && let Some(path) = std::env::var_os("PROFIDRIVE_PLANTED_SEEN")
        && let Ok(mut file) = std::fs::OpenOptions::new().append(true).create(true).open(path)
    {
        let _ = file.write_all(format!("{number}\\n").as_bytes());
    }
    let wanted = || std::env::var("PROFIDRIVE_PLANTED").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    *ON.get_or_init(wanted) == number
}
'''


@dataclasses.dataclass
class Mistake:
    """One change: the octets START to END of PATH become NEW when it is on."""

    path: str
    start: int
    end: int
    line: int
    kind: str
    function: str
    old: str
    new: str
    text: str
    number: int = 0

    @property
    def key(self):
        """What names it while lines move."""
        return f"{self.path} {self.function}: {self.old} -> {self.new}"

    @property
    def folder(self):
        folder = "/".join(self.path.split("/")[:2])
        return folder if folder in SHARES else "elsewhere"


def tracked(root):
    out = subprocess.run(["git", "-C", root, "ls-files", "-z"], check=True, capture_output=True).stdout
    return [name for name in out.decode().split("\0") if name]


def sources(root):
    """The files that are no tests: neither by their names nor by the `mod` that brings them."""
    paths = [
        path
        for path in tracked(root)
        if path.startswith("src/")
        and path.endswith(".rs")
        and path not in ("src/main.rs", "src/lib.rs")
        and "/tests" not in path
        and not path.endswith(("test.rs", "_test.rs"))
    ]
    of_tests = []
    for path in map(pathlib.PurePosixPath, paths):
        folder = path.parent if path.name == "mod.rs" else path.with_suffix("")
        names = TEST_MODULE.findall((pathlib.Path(root) / path).read_text())
        of_tests += [f"{folder}/{name}{end}" for name in names for end in (".rs", "/")]
    return sorted(path for path in paths if not path.startswith(tuple(of_tests)))


def one_line(text):
    return re.sub(r"\s+", " ", text).strip()


def changed_lines(root, base):
    """Of each file, the lines that are new since BASE."""
    diff = subprocess.run(["git", "-C", root, "diff", "-U0", base, "--", "src"], check=True, capture_output=True, text=True)
    lines, path = {}, None
    for row in diff.stdout.splitlines():
        if row.startswith("+++ "):
            path = row[6:]
        elif found := re.match(r"@@ \S+ \+(\d+)(?:,(\d+))? @@", row):
            first, count = int(found[1]), int(found[2] or 1)
            lines.setdefault(path, set()).update(range(first, first + count))
    return lines


class Sites:
    """All places of one file where a mistake can be planted."""

    def __init__(self, path, source):
        self.path, self.source, self.found = path, source, []
        self.visit(tree_sitter.Parser(LANGUAGE).parse(source).root_node, None, "")

    def text(self, node):
        return self.source[node.start_byte : node.end_byte].decode()

    def add(self, node, kind, function, new, text, old=None):
        self.found.append(
            Mistake(self.path, node.start_byte, node.end_byte, node.start_point[0] + 1, kind, function,
                    one_line(old if old is not None else self.text(node))[:160], one_line(new)[:160], text)
        )  # fmt: skip

    def visit(self, node, function, name):
        """FUNCTION: whether NODE is in the body of one; NAME: its name."""
        kind = node.type
        if kind in ("macro_definition", "const_item", "static_item", "attribute_item", "array_type", "type_arguments",
                    "macro_invocation", "const_block", "enum_variant"):  # fmt: skip
            return
        if kind in ("impl_item", "trait_item", "mod_item"):
            named = node.child_by_field_name("type") or node.child_by_field_name("name")
            name = f"{name}::{one_line(self.text(named))}".strip(":") if named else name
        if kind == "function_item":
            head = self.source[node.start_byte : node.child_by_field_name("body").start_byte].decode()
            if re.search(r"\bconst\s+(unsafe\s+)?fn\b", head):
                return
            name = f"{name}::{self.text(node.child_by_field_name('name'))}".strip(":")
            self.body(node, name)
            function = True
        if function:
            self.site(node, name)
        skip_next = False
        for child in node.children:
            if child.type == "attribute_item":
                skip_next = re.search(rf"{FOR_TESTS}|\btest\]", self.text(child)) is not None or skip_next
                continue
            if child.type in ("line_comment", "block_comment"):
                continue
            if skip_next:
                skip_next = False
                continue
            if child.type.endswith("pattern") and child.type != "match_pattern":
                continue
            if node.type in ("let_declaration", "let_condition", "parameter") and child == node.child_by_field_name("pattern"):
                continue
            if node.type == "match_pattern" and child != node.child_by_field_name("condition"):
                continue
            self.visit(child, function, name)

    def body(self, node, name):
        """A function that does nothing."""
        result = node.child_by_field_name("return_type")
        result = self.text(result) if result is not None else None
        block = node.child_by_field_name("body")
        empty = EMPTY.get(result)
        if result and re.match(r"(core::option::)?Option<", result):
            empty = "return None;"
        elif result and re.match(r"Result<\(\)", result):
            empty = "return Ok(());"
        if empty and block.named_child_count:
            first = Mistake(self.path, block.start_byte, block.start_byte + 1, block.start_point[0] + 1, "body", name, "{",
                            empty, "{ if crate::planted::on(@) { " + empty + " }")  # fmt: skip
            self.found.append(first)

    def site(self, node, name):
        kind, here = node.type, self.text(node)
        parent = node.parent.type if node.parent else ""
        on = "crate::planted::on(@)"
        if kind == "binary_expression":
            sign = node.child_by_field_name("operator")
            left, right = node.child_by_field_name("left"), node.child_by_field_name("right")
            if "let " in here and sign.type in ("&&", "||"):
                return
            if other := SWAPS.get(self.text(sign)):
                new = f"{self.text(left)} {other} {self.text(right)}"
                self.add(node, "operator", name, new, f"(if {on} {{ {new} }} else {{ {here} }})")
        elif kind == "integer_literal" and parent not in ("field_expression", "tuple_struct_pattern", "range_pattern"):
            if parent == "array_expression" and b";" in self.source[node.prev_sibling.start_byte : node.prev_sibling.end_byte]:
                return
            digits, suffix = re.match(r"(0x[0-9A-Fa-f_]+?|0b[01_]+?|[0-9_]+?)([iu](?:8|16|32|64|128|size))?$", here).groups()
            new = f"{int(digits.replace('_', ''), 0) + 1}{suffix or ''}"
            self.add(node, "number", name, new, f"(if {on} {{ {new} }} else {{ {here} }})")
        elif kind == "boolean_literal":
            new = "false" if here == "true" else "true"
            self.add(node, "word", name, new, f"!{on}" if here == "true" else on)
        elif kind in ("if_expression", "while_expression"):
            condition = node.child_by_field_name("condition")
            if "let " not in self.text(condition):
                was = self.text(condition)
                self.add(condition, "condition", name, f"!({was})", f"(({was}) != {on})")
        elif kind == "match_pattern":
            guard = node.child_by_field_name("condition")
            if guard is not None and "let " not in self.text(guard):
                was = self.text(guard)
                self.add(guard, "guard", name, "true", f"(({was}) || {on})", old=f"if {was}")
        elif kind == "expression_statement":
            inner = node.named_children[0].type if node.named_children else ""
            if here.endswith(";") and inner in ("call_expression", "assignment_expression", "compound_assignment_expr"):
                self.add(node, "statement", name, "", f"if !{on} {{ {here} }}")
        elif kind == "call_expression":
            called = node.child_by_field_name("function")
            if called.type == "field_expression":
                field = called.child_by_field_name("field")
                if other := CALLS.get(self.text(field)):
                    before = self.source[node.start_byte : field.start_byte].decode()
                    behind = self.source[field.end_byte : node.end_byte].decode()
                    new = before + other + behind
                    self.add(node, "call", name, new, f"(if {on} {{ {new} }} else {{ {here} }})")


def all_sites(root, only=None):
    found = []
    for path in sources(root):
        sites = Sites(path, (pathlib.Path(root) / path).read_bytes()).found
        found += [site for site in sites if only is None or site.line in only.get(path, ())]
    return found


def sample(sites, count, seed, shares):
    """COUNT of the sites, those of each folder by its share; none lies within another."""
    draw = random.Random(seed)
    folders = {}
    for site in sites:
        folders.setdefault(site.folder, []).append(site)
    chosen, taken = [], {}
    whole = sum(shares.get(folder, 0) for folder in folders) or 1
    for folder, own in sorted(folders.items()):
        wanted = -(-count * shares.get(folder, 0) // whole)
        draw.shuffle(own)
        numbers = 0
        for site in own:
            if wanted == 0:
                break
            if site.kind == "number" and numbers >= NUMBERS_AT_MOST * count * shares[folder] / whole:
                continue
            spans = taken.setdefault(site.path, [])
            if any(site.start < end and start < site.end for start, end in spans):
                continue
            spans.append((site.start, site.end))
            numbers += site.kind == "number"
            chosen.append(site)
            wanted -= 1
    for number, site in enumerate(chosen, 1):
        site.number = number
    return chosen


def write_tree(root, tree, mistakes):
    """Makes TREE the sources of ROOT with the mistakes; gives where in its files each lies now."""
    places = {}
    by_path = {}
    for mistake in mistakes:
        by_path.setdefault(mistake.path, []).append(mistake)
    kept = set()
    for path in tracked(root):
        source, target = pathlib.Path(root) / path, tree / path
        if not source.is_file():
            continue
        kept.add(path)
        text = source.read_bytes()
        if own := by_path.get(path):
            out, at = b"", 0
            for mistake in sorted(own, key=lambda m: m.start):
                out += text[at : mistake.start]
                planted = mistake.text.replace("@", str(mistake.number)).encode()
                places.setdefault(path, []).append((len(out), len(out) + len(planted), mistake.number))
                out, at = out + planted, mistake.end
            text = out + text[at:]
        if path == "src/lib.rs":
            text = text.replace(b"\npub mod time;\n", b"\nmod planted;\npub mod time;\n")
        put(target, text, source)
    count = max((m.number for m in mistakes), default=0)
    put(tree / "src/planted.rs", f"const COUNT: usize = {count};\n".encode() + PLANTED.encode(), None)
    for old in tree.rglob("*"):
        name = str(old.relative_to(tree))
        if old.is_file() and name.startswith("src/") and name not in kept and name != "src/planted.rs":
            old.unlink()
    return places


def put(target, octets, mode_of):
    """Writes a file if it differs, so that nothing is compiled twice."""
    if target.is_file() and target.read_bytes() == octets:
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(octets)
    if mode_of is not None:
        shutil.copymode(mode_of, target)


def compiled(tree, target, places, *command):
    """What cargo made, as its messages, and the numbers of the mistakes that do not compile."""
    run = subprocess.run(
        ["cargo", "test", "--no-run", *command, "--all-features", "--message-format=json", "--target-dir", target],
        cwd=tree, capture_output=True, text=True,
    )  # fmt: skip
    rows = [json.loads(line) for line in run.stdout.splitlines()]
    if run.returncode == 0:
        return rows, set()
    bad, lost = set(), []
    for message in filter(None, (row.get("message") for row in rows)):
        if message.get("level") != "error" or not message["spans"]:
            continue
        spans = message["spans"] + [span for child in message["children"] for span in child["spans"]]
        hits = {number for span in spans for start, end, number in places.get(span["file_name"], ())
                if span["byte_start"] < end and start < span["byte_end"]}  # fmt: skip
        if not hits:
            # What is left out may be missed further down: the nearest one above it.
            above = [place for span in spans for place in places.get(span["file_name"], ()) if place[1] <= span["byte_start"]]
            hits = {max(above)[2]} if above else set()
            lost.append(message["rendered"])
        bad |= hits
    if not bad:
        said = "\n".join(lost[:3] or [run.stderr[-2000:]])
        raise SystemExit(f"the sources with mistakes do not compile, and no mistake is the reason:\n{said}")
    return rows, bad
