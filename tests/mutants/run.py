"""Whether the tests find mistakes: plants a seeded sample of them in one build, and runs for each the tests that reach it.

    tests/mutants/run --seed 1 --count 400           a sample of all of src, by the shares of plant.py
    tests/mutants/run --changed-since REV --count 20  a sample of the lines that are new since REV
    tests/mutants/run --show                         what the last run found

Every test runs alone, first without a mistake: that says which mistakes it reaches and how long it takes. For each
mistake the tests that reach it run, the nearest first, until one fails. A mistake that no test finds is listed, and the
run ends with 1 if fewer were found than --at-least says. Interrupted, the same command goes on.
"""
import argparse
import concurrent.futures
import dataclasses
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import time
import tomllib

import plant

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# A test that takes this much longer than alone has been hung up by the mistake.
PATIENCE = 8
LEAST_LIMIT = 40


def main():
    wanted = arguments()
    work = pathlib.Path(wanted.work).resolve()
    work.mkdir(parents=True, exist_ok=True)
    if wanted.show:
        raise SystemExit(report(work, wanted))
    plan = work / "plan.json"
    said = {"seed": wanted.seed, "count": wanted.count, "since": wanted.changed_since, "head": head()}
    if not plan.is_file() or json.loads(plan.read_text())["said"] != said:
        mistakes, every = build(work, wanted)
        for old in ("alone.json", "found.jsonl"):
            (work / old).unlink(missing_ok=True)
        plan.write_text(json.dumps({"said": said, "tests": every, "mistakes": [dataclasses.asdict(m) for m in mistakes]}))
    alone(work, wanted.jobs)
    judge(work, wanted)
    raise SystemExit(report(work, wanted))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=400, help="how many mistakes that compile are wanted (400)")
    parser.add_argument("--changed-since", metavar="REV", help="only in lines that are new since this commit")
    parser.add_argument("--at-least", type=int, default=0, metavar="PERCENT", help="of which fewer found are a failure (0)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="tests at a time")
    parser.add_argument("--work", default=str(ROOT / "target/mutants"), help="where the build and the results lie")
    parser.add_argument("--show", action="store_true", help="what the last run found; nothing is run")
    return parser.parse_args()


def head():
    return subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()


def build(work, wanted):
    """The mistakes that compile, all in one build, and every test of it."""
    only = plant.changed_lines(ROOT, wanted.changed_since) if wanted.changed_since else None
    sites = plant.all_sites(ROOT, only)
    # Some do not compile: more are drawn than are wanted.
    mistakes = plant.sample(sites, wanted.count * 11 // 10 + 3, wanted.seed, plant.SHARES)
    drawn = len(mistakes)
    tree, target = work / "tree", work / "target"
    # What the first finds costs less; some is found by the second only.
    for command in (["check", "--lib"], ["test", "--no-run"]):
        while True:
            made, bad = plant.compiled(tree, target, plant.write_tree(ROOT, tree, mistakes), *command)
            if not bad:
                break
            mistakes = [m for m in mistakes if m.number not in bad]
    if len(mistakes) > wanted.count:
        mistakes = sorted(random.Random(wanted.seed).sample(mistakes, wanted.count), key=lambda m: m.number)
    print(f"{len(sites)} places, {drawn} drawn, {len(mistakes)} that compile are tried", flush=True)
    return mistakes, tests(tree, made)


def tests(tree, made):
    """Every test of the build, with its program."""
    programs = [row["executable"] for row in made if row.get("executable") and row.get("profile", {}).get("test")]
    found = []
    for program in programs:
        listed = subprocess.run([program, "--list", "--format", "terse"], cwd=tree, check=True, capture_output=True, text=True)
        found += [[program, row[:-6]] for row in listed.stdout.splitlines() if row.endswith(": test")]
    return found


def run_test(work, test, limit, **environment):
    """Whether one test passes within so many seconds, and how long it takes."""
    program, name = test
    began = time.monotonic()
    child = subprocess.Popen(
        [program, "--exact", name, "--test-threads", "1"], cwd=work / "tree", start_new_session=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={**os.environ, **environment},
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
    return passed, time.monotonic() - began


def alone(work, jobs):
    """What each test reaches, and how long it takes."""
    if (work / "alone.json").is_file():
        return
    every = json.loads((work / "plan.json").read_text())["tests"]
    seen_in = work / "seen"
    seen_in.mkdir(exist_ok=True)

    def one(number):
        seen = seen_in / str(number)
        seen.unlink(missing_ok=True)
        passed, took = run_test(work, every[number], 300, PROFIDRIVE_PLANTED_SEEN=str(seen))
        reached = sorted({int(row) for row in seen.read_text().split()}) if seen.is_file() else []
        return {"test": every[number], "passed": passed, "took": round(took, 3), "reaches": reached}

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        rows = list(pool.map(one, range(len(every))))
    failed = [row["test"][1] for row in rows if not row["passed"]]
    print(f"{len(rows)} tests, {len(failed)} fail without a mistake and are left out: {', '.join(failed) or 'none'}", flush=True)
    (work / "alone.json").write_text(json.dumps(rows))


def judge(work, wanted):
    """For each mistake the first test that fails."""
    plan = json.loads((work / "plan.json").read_text())
    rows = [row for row in json.loads((work / "alone.json").read_text()) if row["passed"]]
    found = work / "found.jsonl"
    done = {json.loads(line)["number"] for line in found.read_text().splitlines()} if found.is_file() else set()

    def one(mistake):
        number = mistake["number"]
        reach = [row for row in rows if number in row["reaches"]]
        reach.sort(key=lambda row: row["took"] + 0.02 * len(row["reaches"]))
        began = time.monotonic()
        for row in reach:
            limit = max(LEAST_LIMIT, row["took"] * PATIENCE)
            if run_test(work, row["test"], limit, PROFIDRIVE_PLANTED=str(number))[0]:
                continue
            # Not by load: without the mistake it passes.
            if run_test(work, row["test"], limit)[0]:
                return {"number": number, "by": row["test"][1], "reached": len(reach), "took": time.monotonic() - began}
        return {"number": number, "by": None, "reached": len(reach), "took": time.monotonic() - began}

    todo = [mistake for mistake in plan["mistakes"] if mistake["number"] not in done]
    with concurrent.futures.ThreadPoolExecutor(wanted.jobs) as pool, found.open("a") as out:
        for result in pool.map(one, todo):
            out.write(json.dumps(result) + "\n")
            out.flush()


def report(work, wanted):
    """Prints what was found, and gives the status."""
    plan = json.loads((work / "plan.json").read_text())
    mistakes = {m["number"]: plant.Mistake(**m) for m in plan["mistakes"]}
    results = [json.loads(line) for line in (work / "found.jsonl").read_text().splitlines()]
    listed = {row["mistake"]: row["reason"] for row in tomllib.loads((HERE / "equivalent.toml").read_text()).get("equivalent", [])}
    folders, left = {}, []
    for result in results:
        mistake = mistakes[result["number"]]
        caught, whole = folders.setdefault(mistake.folder, [0, 0])
        if result["by"] is None and mistake.key in listed:
            continue
        folders[mistake.folder] = [caught + (result["by"] is not None), whole + 1]
        if result["by"] is None:
            left.append((mistake, result["reached"]))
    for mistake, reached in sorted(left, key=lambda row: (row[0].path, row[0].line)):
        print(f"{mistake.path}:{mistake.line}: not found ({reached} tests reach it)\n    {mistake.key}")
    caught, whole = (sum(column) for column in zip(*folders.values())) if folders else (0, 0)
    for folder, (own, of) in sorted(folders.items()):
        print(f"{folder:16} {own:4} of {of:4} found  {100 * own / max(1, of):5.1f} %")
    share = 100 * caught / max(1, whole)
    print(f"{'all':16} {caught:4} of {whole:4} found  {share:5.1f} %   seed {plan['said']['seed']}, {plan['said']['head'][:8]}")
    if len(results) < len(mistakes):
        print(f"not finished: {len(results)} of {len(mistakes)} were tried")
        return 1
    return 0 if whole and share >= wanted.at_least else 1


if __name__ == "__main__":
    sys.exit(main())
