#!/usr/bin/env python3
"""Runs a GoogleTest program to its end, whatever happens, and counts: run_tests.py PROGRAM [FOLDER OF JAVASCRIPT TESTS]

A test that crashes or hangs counts as failed, and the tests after it still run: the program is started again without
those that are done. Ends with the line "N passed, N failed, N skipped"; exit code 0 only where none failed.

MVW_TEST_SECONDS: another time without a word after which a test is taken to hang (sanitizers are slow).
MVW_TEST_SHARD=K/N: only every N-th test, from the K-th (from 0), so that several of these share the work.
"""
import os
import re
import signal
import subprocess
import sys
import time

TEST_SECONDS = int(os.environ.get("MVW_TEST_SECONDS", 240))  # a test without a word for this long is taken to hang
ENDS = {"       OK ": "passed", "  FAILED  ": "failed", "  SKIPPED ": "skipped"}


def list_tests(program):
    text = subprocess.run([program, "--gtest_list_tests"], check=True, capture_output=True, text=True).stdout
    tests, suite = [], ""
    for line in text.splitlines():
        name = line.split("#")[0].rstrip()
        if name.endswith(".") and not name.startswith(" "):
            suite = name
        elif name.startswith("  "):
            tests.append(suite + name.strip())
    return [t for t in tests if "DISABLED_" not in t]


def run_once(program, tests, results):
    """Starts the program on `tests`; notes each result. Returns what ended it early, or None."""
    command = [program, "--gtest_filter=" + ":".join(tests)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, bufsize=0)
    current = None
    previous = signal.signal(signal.SIGALRM, lambda *_: process.kill())
    try:
        signal.alarm(TEST_SECONDS)
        for raw in process.stdout:
            signal.alarm(TEST_SECONDS)
            sys.stdout.write(raw.decode(errors="replace"))
            sys.stdout.flush()
            line = raw.decode(errors="replace")
            found = re.match(r"\[(.{10})\] (\S+?)(?: \(\d+ ms\)|,.*)?$", line.rstrip())
            if not found or found[2] not in tests:
                continue
            if found[1] == " RUN      ":
                current = found[2]
            elif found[1] in ENDS and found[2] == current:
                results[current] = ENDS[found[1]]
                current = None
        code = process.wait()
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, previous)
    if current is not None:
        results[current] = "failed"
        return f"{current} ended the program (exit code {code})"
    if code != 0 and "failed" not in results.values():
        return f"the program ended with exit code {code} though no test failed"
    return None


def run_javascript(folder):
    """Runs node's test runner on a folder; its count of each kind."""
    process = subprocess.Popen(["node", "--test", "--test-reporter=tap", folder], stdout=subprocess.PIPE, text=True)
    count = dict.fromkeys(ENDS.values(), 0)
    kinds = {"pass": "passed", "fail": "failed", "cancelled": "failed", "skipped": "skipped"}
    for line in process.stdout:
        if found := re.match(r"# (pass|fail|cancelled|skipped) (\d+)$", line):
            count[kinds[found[1]]] += int(found[2])
        elif not re.match(r"\s+(---|\.\.\.|duration_ms|type:)", line):
            sys.stdout.write(line)
    if process.wait() != 0 and count["failed"] == 0 or count["passed"] == 0:
        count["failed"] += 1  # it ended before it could count
    return count


def main():
    program = sys.argv[1]
    javascript = sys.argv[2] if len(sys.argv) > 2 else None
    shard, shards = map(int, os.environ.get("MVW_TEST_SHARD", "0/1").split("/"))
    tests, results, troubles, start = list_tests(program)[shard::shards], {}, [], time.time()
    while True:
        left = [t for t in tests if t not in results]
        if not left:
            break
        trouble = run_once(program, left, results)
        if trouble:
            troubles.append(trouble)
        if len([t for t in tests if t not in results]) == len(left):
            for t in left:
                results[t] = "failed"  # the program does not even reach a test
    for trouble in troubles:
        print("FAILED:", trouble)
    for test in tests:
        if results[test] == "failed":
            print("FAILED:", test)
    count = {kind: sum(r == kind for r in results.values()) for kind in ENDS.values()}
    if troubles and count["failed"] == 0:
        count["failed"] = 1  # a crash or a leak after the last test
    if javascript:
        for kind, number in run_javascript(javascript).items():
            count[kind] += number
    print(f"({time.time() - start:.0f} s)")
    print(f"{count['passed']} passed, {count['failed']} failed, {count['skipped']} skipped")
    return 1 if count["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
