"""norma on a Dask cluster. A job is a process of the tool that writes one file, complete or not at all, so a job whose worker
was killed can be run again by another.

    python3 norma_dask.py check MODELS REPORT [SCHEDULER]
    python3 norma_dask.py seams TILES OUT [SCHEDULER]

All workers must see the folders under the same paths. Without a scheduler's address, workers run on this machine.
"""
import glob
import os
import shutil
import subprocess
import sys
import tempfile

RETRIES = 3  # of a job; a worker that dies takes its jobs with it, and they count as well


def norma(*arguments):
    """Runs the tool. What stops it is an exception with its message, by which Dask runs the job again."""
    done = subprocess.run(["norma", *arguments], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError("norma %s: status %d: %s" % (" ".join(arguments[:2]), done.returncode, done.stderr.strip()))


def check_part(models, i, count, report):
    norma("check", models, "--shard", "%d/%d" % (i, count), "--threads", "1", "--exit", "job", "--quiet", "--format", "json", "-o", report)
    return report


def check(client, models, report, parts=16):
    """The exit status is that of one run over all files; the report has its bytes."""
    work = tempfile.mkdtemp(dir=os.path.dirname(os.path.abspath(report)))
    try:
        jobs = [client.submit(check_part, models, i, parts, "%s/%d.json" % (work, i), retries=RETRIES, pure=False) for i in range(1, parts + 1)]
        return subprocess.run(["norma", "report", "--merge", *client.gather(jobs), "-o", report]).returncode
    finally:  # other jobs may still write there after one that failed
        shutil.rmtree(work, ignore_errors=True)


def votes(tiles, output):
    norma("seams", "votes", *tiles, "--threads", "1", "--quiet", "-o", output)
    return output


def merge(files, output, tiles=None):
    norma("seams", "merge", *files, "--quiet", "-o", output, *(["--tiles", str(tiles)] if tiles else []))
    return output


def apply(tiles, all_votes, out):
    norma("seams", "apply", *tiles, "--votes", all_votes, "--threads", "1", "--quiet", "--out-dir", out)
    return len(tiles)


def seams(client, tiles, out, in_job=20, fan=16):
    """One normal at the seams of all PLY tiles of a folder: votes, a tree of merges, apply."""
    names = sorted(glob.glob(os.path.join(tiles, "*.ply")))
    if not names:
        raise FileNotFoundError("%s: holds no PLY file" % tiles)
    groups = [names[i:i + in_job] for i in range(0, len(names), in_job)]
    os.makedirs(out, exist_ok=True)
    work = tempfile.mkdtemp(dir=os.path.dirname(os.path.abspath(out)))
    try:
        level = [client.submit(votes, g, "%s/0-%d" % (work, i), retries=RETRIES, pure=False) for i, g in enumerate(groups)]
        depth = 0
        while len(level) > 1:
            depth += 1
            last = len(level) <= fan
            level = [client.submit(merge, level[i:i + fan], "%s/%d-%d" % (work, depth, i), len(names) if last else None, retries=RETRIES, pure=False)
                     for i in range(0, len(level), fan)]
        return sum(client.gather([client.submit(apply, g, level[0], out, retries=RETRIES, pure=False) for g in groups]))
    finally:
        shutil.rmtree(work, ignore_errors=True)


def main(what, folder, output, *scheduler):
    import dask
    from distributed import Client

    dask.config.set({"distributed.scheduler.allowed-failures": 10})  # of the workers under one job
    with Client(*scheduler or [None]) as client:
        if what == "check":
            return check(client, folder, output)
        try:
            print("%d tiles" % seams(client, folder, output))
        except (FileNotFoundError, RuntimeError) as problem:  # no tile; what the tool said
            return str(problem)
        return 0


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5) or sys.argv[1] not in ("check", "seams"):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
