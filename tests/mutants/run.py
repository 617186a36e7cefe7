"""Whether the tests find mistakes: plants a seeded sample of them in one build, and runs for each the tests that reach it.

    tests/mutants/run --seed 1 --count 400           a sample of all of src, by the shares of plant.py
    tests/mutants/run --changed-since REV --count 20  a sample of the lines that are new since REV
    tests/mutants/run --again DIR --work OTHER       what the run in DIR did not find, in the sources of now
    tests/mutants/run --show                         what the last run found

Program by program, every test runs alone, first without a mistake: that says which mistakes it reaches and how long it
takes. For each mistake the tests that reach it run, the nearest first, until one fails. A mistake that no test finds is listed, and the
run ends with 1 if fewer were found than --at-least says. Interrupted, the same command goes on.
"""
import argparse
import concurrent.futures
import dataclasses
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import tomllib

import plant

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# A test that takes this much longer than alone has been hung up by the mistake.
PATIENCE = 8
LEAST_LIMIT = 40
# So many seconds of tests run in one process, and so many tests.
BATCH = 4
MOST = 60


def main():
    wanted = arguments()
    work = pathlib.Path(wanted.work).resolve()
    work.mkdir(parents=True, exist_ok=True)
    if wanted.show:
        raise SystemExit(report(work, wanted))
    plan = work / "plan.json"
    said = {"seed": wanted.seed, "count": wanted.count, "since": wanted.changed_since, "again": wanted.again, "head": head()}
    if not plan.is_file() or json.loads(plan.read_text())["said"] != said:
        mistakes = missed_before(pathlib.Path(wanted.again)) if wanted.again else drawn(wanted)
        for old in ("plan.json", "programs.json", "alone.jsonl", "tried.jsonl"):
            (work / old).unlink(missing_ok=True)
        mistakes = build(work, wanted, said, mistakes)
        plan.write_text(
            json.dumps({"said": said, "programs": programs(), "mistakes": [dataclasses.asdict(m) for m in mistakes]})
        )
    judge(work, wanted)
    raise SystemExit(report(work, wanted))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=400, help="how many mistakes that compile are wanted (400)")
    parser.add_argument("--changed-since", metavar="REV", help="only in lines that are new since this commit")
    parser.add_argument("--again", metavar="DIR", help="only what a run in this folder did not find")
    parser.add_argument("--at-least", type=int, default=0, metavar="PERCENT", help="of which fewer found are a failure (0)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="tests at a time")
    parser.add_argument("--patience", type=int, default=180, metavar="SECONDS", help="for one mistake in one program (180)")
    parser.add_argument("--only", metavar="PROGRAM", help="the tests of this program only; some may run at the same time")
    parser.add_argument("--work", default=str(ROOT / "target/mutants"), help="where the build and the results lie")
    parser.add_argument("--show", action="store_true", help="what the last run found; nothing is run")
    return parser.parse_args()


def head():
    return subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()


def drawn(wanted):
    """A sample of the sources."""
    only = plant.changed_lines(ROOT, wanted.changed_since) if wanted.changed_since else None
    sites = plant.all_sites(ROOT, only)
    # Some do not compile: more are drawn than are wanted.
    mistakes = plant.sample(sites, wanted.count * 11 // 10 + 3, wanted.seed, plant.SHARES)
    print(f"{len(sites)} places, {len(mistakes)} drawn", flush=True)
    return mistakes


def missed_before(work):
    """What another run did not find, at its places now. Code that is gone since has no mistakes."""
    sites = {}
    for site in plant.all_sites(ROOT):
        sites.setdefault(site.key, []).append(site)
    mistakes = []
    for old, _ in missed(work):
        same = [site for site in sites.get(old.key, ()) if site not in mistakes]
        if not same:
            print(f"gone: {old.key}", flush=True)
            continue
        site = min(same, key=lambda site: abs(site.line - old.line))
        site.number = len(mistakes) + 1
        mistakes.append(site)
    return mistakes


def build(work, wanted, said, mistakes):
    """The mistakes that compile, all in one build of the library."""
    broken = work / "broken.json"
    known = json.loads(broken.read_text()) if broken.is_file() else {}
    bad = set(known["numbers"]) if known.get("said") == said else set()
    while True:
        mistakes = [m for m in mistakes if m.number not in bad]
        places = plant.write_tree(ROOT, work / "tree", mistakes)
        _, more = plant.compiled(work / "tree", work / "target", places, "--lib")
        if not more:
            break
        bad |= more
        broken.write_text(json.dumps({"said": said, "numbers": sorted(bad)}))
        print(f"{len(bad)} do not compile", flush=True)
    if len(mistakes) > wanted.count:
        mistakes = sorted(random.Random(wanted.seed).sample(mistakes, wanted.count), key=lambda m: m.number)
    print(f"{len(mistakes)} that compile are tried", flush=True)
    return mistakes


def programs():
    """The library, and every test program; those that start others come last."""
    told = subprocess.run(
        ["cargo", "metadata", "--no-deps", "--format-version", "1"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    targets = json.loads(told.stdout)["packages"][0]["targets"]
    names = [target["name"] for target in targets if target["kind"] == ["test"]]
    return ["lib", *sorted(names, key=lambda name: (name in ("line", "command"), name))]


def tests(work, program):
    """Every test of a program, built if it has not been."""
    path = work / "programs.json"
    known = json.loads(path.read_text()) if path.is_file() else {}
    if program not in known:
        which = ["--lib"] if program == "lib" else ["--test", program]
        made, _ = plant.compiled(work / "tree", work / "target", {}, *which)
        built = [row["executable"] for row in made if row.get("executable") and row.get("profile", {}).get("test")]
        known[program] = [
            [file, row[:-6]]
            for file in built
            for row in subprocess.run(
                [file, "--list", "--format", "terse"], cwd=work / "tree", check=True, capture_output=True, text=True
            ).stdout.splitlines()
            if row.endswith(": test")
        ]  # fmt: skip
        path.write_text(json.dumps(known))
    return known[program]


def run_tests(work, tests, limit, threads=1, **environment):
    """Whether tests of one program pass within so many seconds, which one fails first, and how long they take."""
    program, names = tests[0][0], [name for _, name in tests]
    began = time.monotonic()
    with tempfile.TemporaryFile("w+") as said:
        child = subprocess.Popen(
            [program, "--exact", *names, "--test-threads", str(threads)], cwd=work / "tree", start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.DEVNULL, env={**os.environ, **environment},
        )  # fmt: skip
        try:
            passed = child.wait(limit) == 0
        except subprocess.TimeoutExpired:
            passed = False
        try:
            os.killpg(child.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        child.wait()
        said.seek(0)
        failed = re.search(r"^test (\S+) .*FAILED$", said.read(), re.MULTILINE)
    return passed, failed[1] if failed else names[0], time.monotonic() - began


def rows_of(path):
    """What was written so far, one thing a line."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.is_file() else []


def each(jobs, work_on, things, path):
    """Does it for each thing, and writes what comes of it."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool, path.open("a") as out:
        for result in filter(None, pool.map(work_on, things)):
            out.write(json.dumps(result) + "\n")
            out.flush()


def alone(work, jobs, tests):
    """What each test of a program reaches, and how long it takes."""
    done = {tuple(row["test"]) for row in rows_of(work / "alone.jsonl")}

    def one(test):
        with tempfile.NamedTemporaryFile() as seen:
            passed, _, took = run_tests(work, [test], 300, PROFIDRIVE_PLANTED_SEEN=seen.name)
            reached = sorted({int(row) for row in seen.read().split()})
        return {"test": test, "passed": passed, "took": round(took, 3), "reaches": reached}

    each(jobs, one, [test for test in tests if tuple(test) not in done], work / "alone.jsonl")


def batches(reach):
    """The tests that reach a mistake, the nearest first, some at a time; those that take long by themselves, and last."""
    batch, took = [], 0.0
    for row in sorted(reach, key=lambda row: row["took"] + 0.02 * len(row["reaches"])):
        if batch and (took + row["took"] > BATCH or len(batch) >= MOST):
            yield batch
            batch, took = [], 0.0
        batch.append(row)
        took += row["took"]
    if batch:
        yield batch


def found_by(work, number, batch, jobs):
    """The test of some that fails by a mistake, if one does."""
    tests, planted = [row["test"] for row in batch], {"PROFIDRIVE_PLANTED": str(number)}
    limit = max(LEAST_LIMIT, PATIENCE * sum(row["took"] for row in batch))
    passed, by, took = run_tests(work, tests, limit, jobs, **planted)
    if passed:
        return None
    # Not by load: without the mistake they pass, and in a part of the time.
    passed, _, usual = run_tests(work, tests, limit, jobs)
    if passed and (took < limit or usual * 3 < limit):
        return by
    if len(batch) == 1:
        return None
    return next(filter(None, (found_by(work, number, [row], 1) for row in batch)), None)


def judge(work, wanted):
    """Program by program: what its tests reach, and which mistakes they find that no test of those before has found."""
    plan = json.loads((work / "plan.json").read_text())
    tried = work / "tried.jsonl"
    for program in [wanted.only] if wanted.only else plan["programs"]:
        own = tests(work, program)
        alone(work, wanted.jobs, own)
        rows = [row for row in rows_of(work / "alone.jsonl") if row["passed"] and row["test"] in own]

        def is_done(number, program=program):
            return any(row["number"] == number and (row["by"] or row["program"] == program) for row in rows_of(tried))

        def one(mistake, rows=rows, program=program, is_done=is_done):
            number, began, by = mistake["number"], time.monotonic(), None
            if is_done(number):
                return None
            reach = [row for row in rows if number in row["reaches"]]
            left = len(reach)
            for batch in batches(reach):
                if time.monotonic() - began > wanted.patience:
                    break
                left -= len(batch)
                by = found_by(work, number, batch, wanted.jobs)
                if by:
                    break
            return {"number": number, "program": program, "by": by, "reached": len(reach), "left": left}

        each(1, one, plan["mistakes"], tried)
    failed = [row["test"][1] for row in rows_of(work / "alone.jsonl") if not row["passed"]]
    if failed:
        print(f"{len(failed)} tests fail without a mistake and are left out: {', '.join(failed)}")


def state(work):
    """The mistakes of a run with what was tried of each, by number; those that are still open apart."""
    plan = json.loads((work / "plan.json").read_text())
    tries = {}
    for row in rows_of(work / "tried.jsonl"):
        tries.setdefault(row["number"], []).append(row)
    tried, still_open = [], []
    for mistake in (plant.Mistake(**m) for m in plan["mistakes"]):
        own = tries.get(mistake.number, [])
        done = any(row["by"] for row in own) or len(own) == len(plan["programs"])
        (tried if done else still_open).append((mistake, own))
    return tried, still_open


def missed(work):
    """What no test found, and is no equivalent."""
    listed = {row["mistake"] for row in tomllib.loads((HERE / "equivalent.toml").read_text()).get("equivalent", [])}
    return [(m, own) for m, own in state(work)[0] if not any(row["by"] for row in own) and m.key not in listed]


def report(work, wanted):
    """Prints what was found, and gives the status."""
    said = json.loads((work / "plan.json").read_text())["said"]
    tried, still_open = state(work)
    not_found = missed(work)
    folders = {}
    for mistakes, found in (([m for m, own in tried if any(row["by"] for row in own)], 1), ([m for m, _ in not_found], 0)):
        for mistake in mistakes:
            caught, whole = folders.get(mistake.folder, (0, 0))
            folders[mistake.folder] = (caught + found, whole + 1)
    not_found = [(m, sum(row["reached"] for row in own), sum(row["left"] for row in own)) for m, own in not_found]
    for mistake, reached, left in sorted(not_found, key=lambda row: (row[0].path, row[0].line)):
        to_the_end = f", not tried to the end: {left} of them left" if left else ""
        print(f"{mistake.path}:{mistake.line}: not found ({reached} tests reach it{to_the_end})\n    {mistake.key}")
    caught, whole = (sum(column) for column in zip(*folders.values())) if folders else (0, 0)
    for folder, (own, of) in sorted(folders.items()):
        print(f"{folder:16} {own:4} of {of:4} found  {100 * own / of:5.1f} %")
    share = 100 * caught / max(1, whole)
    print(f"{'all':16} {caught:4} of {whole:4} found  {share:5.1f} %   seed {said['seed']}, {said['head'][:8]}")
    if still_open:
        print(f"not finished: {len(still_open)} of {len(still_open) + len(tried)} are still open")
        return 1
    return 0 if whole and share >= wanted.at_least else 1


if __name__ == "__main__":
    sys.exit(main())
