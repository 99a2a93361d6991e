#!/usr/bin/env python3
"""Builds the fuzz targets under the address and undefined sanitizers and runs them: tests/fuzz/run.py [-s SECONDS] [TARGET...]

Default: every target for 600 seconds, as many side by side as there are cores. What a target learns is kept in
build-fuzz/corpus/TARGET for the next run; where a target reads files, it begins with the golden ones of tests/data. An input that fails is left in
build-fuzz/found, to become a test. Ends with a line for each target; exit code 1 where one has failed.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import zipfile

TREE = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = TREE / "build-fuzz"
# What comes before a golden file in an input (the targets' head comments): a byte that says how it is to be taken.
SEEDS = {"container_fuzz": [("*.mvw", b"")], "decoder_fuzz": [("*.mvw", b"\0")],
         "import_fuzz": [("*.off", b"\3"), ("*.glb", b"\5"), ("*.3mf", b"\6")]}


def corpus_of(target):
    corpus = BUILD / "corpus" / target
    corpus.mkdir(parents=True, exist_ok=True)
    for pattern, head in SEEDS.get(target, []):
        for golden in sorted((TREE / "tests" / "data").glob(pattern)):
            (corpus / golden.name).write_bytes(head + golden.read_bytes())
    if target == "threemf_fuzz":
        for golden in sorted((TREE / "tests" / "data").glob("*.3mf")):
            with zipfile.ZipFile(golden) as package:
                (corpus / golden.stem).write_bytes(b"\x40" + package.read("3D/3dmodel.model"))
    return corpus


def run(target, seconds):
    """The target's name, how many inputs it ran, and its last lines where it failed, else none."""
    found = BUILD / "found"
    found.mkdir(exist_ok=True)
    command = [BUILD / target, f"-max_total_time={seconds}", "-rss_limit_mb=2048", "-timeout=20", "-max_len=50000",
               f"-artifact_prefix={found}/{target}-", "-print_final_stats=1", corpus_of(target)]
    ended = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    runs = re.search(r"stat::number_of_executed_units:\s*(\d+)", ended.stderr)
    return target, int(runs.group(1)) if runs else 0, ended.stderr[-3000:] if ended.returncode else None


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("-s", "--seconds", type=int, default=600, help="for each target (600)")
    arguments.add_argument("target", nargs="*", help="default: all")
    asked = arguments.parse_args()
    known = sorted(f.stem for f in (TREE / "tests" / "fuzz").glob("*_fuzz.cpp"))
    for name in asked.target:
        if name not in known:
            sys.exit(f"run.py: no target is called {name}; there are {', '.join(known)}")
    targets = asked.target or known
    subprocess.run(["cmake", "--preset", "fuzz"], cwd=TREE, check=True)
    subprocess.run(["cmake", "--build", "--preset", "fuzz", "--target", *targets], cwd=TREE, check=True)
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, runs, end in pool.map(lambda t: run(t, asked.seconds), targets):
            print(f"{name}: {runs:,} inputs, {'failed' if end is not None else 'clean'}", flush=True)
            if end is not None:
                failed += 1
                print(end)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
