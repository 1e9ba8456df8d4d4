#!/bin/bash
# examples/farm: each recipe on a local cluster of its engine (make farms installs them): reports have the bytes of one run, tiles those of one --together, workers are killed.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$scratch" || exit 1
mkdir -p bin "my models/sub"
ln -s "$(realpath "${NORMA_BIN:-$tree/bin/norma}")" bin/norma
export PATH=$scratch/bin:$PATH
farm=$root/examples/farm files=$root/tests/cli/golden/files
for i in $(seq 30); do cp "$files/cube.obj" "my models/sub/cube$i.obj"; cp "$files/roof.ply" "my models/roof$i.ply"; done
cp "$files/malformed.obj" "my models/broken.obj"
for i in 1 2 3; do printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n' >"my models/zero$i.obj"; done
norma check "my models" --format json -o whole.json --quiet
whole=$?
python3 "$root/tests/cli/seams_tiles.py" tiles 12 8 "my tiles"
mv "my tiles/$(ls "my tiles" | head -n 1)" "my tiles/a  tile.ply" # two spaces: a second shell would make them one
norma compute "my tiles" --together --out-dir together --quiet
mkdir "my tiles/below" # outputs keep base names, so recipes leave folders below alone
printf 'ply\nno tile' | tee "my tiles/below/t001-000.ply" >"my tiles/below/other.ply"

# engine NAME COMMAND: whether it is there.
engine() { "${@:2}" >/dev/null 2>&1 || { skip "$1 is not installed (make farms)"; return 1; }; }
# same_report NAME STATUS REPORT
same_report() {
    if [ "$2" = $whole ] && cmp whole.json "$3" >said 2>&1; then pass "$1: the report and the status of one run"; else fail "$1: the report and the status of one run" "status $2, not $whole; $(cat said)"; fi
}
check "one run finds what it should: status 3" test $whole = 3

# ---- GNU parallel
if engine "GNU parallel" bash -c 'parallel --version | grep -q GNU'; then
    "$farm/parallel/check.sh" "my models" 7 parallel.json
    same_report "GNU parallel" $? parallel.json
    check "GNU parallel: tiles" "$farm/parallel/seams.sh" "my tiles" parallel
    check "GNU parallel: the bits of one --together" diff -rq together parallel
    # The first process of each job is killed: parallel starts it again.
    mkdir killing
    cat >killing/norma <<END
#!/bin/sh
[ "\$2" = merge ] || ! mkdir "$scratch/killing/once-\$(echo "\$*" | md5sum | cut -c 1-8)" 2>/dev/null || kill -9 \$\$
exec "$scratch/bin/norma" "\$@"
END
    chmod +x killing/norma
    check "GNU parallel: each job killed once" env "PATH=$scratch/killing:$PATH" "$farm/parallel/seams.sh" "my tiles" killed
    check "GNU parallel: the bits of one --together, all the same" diff -rq together killed
    check "jobs were killed" bash -c '[ "$(ls -d killing/once-* | wc -l)" -gt 10 ]'
fi

# ---- Snakemake
if engine Snakemake snakemake --version; then
    mkdir snake
    check "Snakemake runs" snakemake --snakefile "$farm/snakemake/Snakefile" --directory snake --cores 2 --retries 2 --quiet rules --config "models=$scratch/my models" "tiles=$scratch/my tiles" parts=5
    norma check "$scratch/my models" --format json -o absolute.json --quiet
    check "Snakemake: the report of one run" cmp absolute.json snake/report.json
    check "Snakemake: the bits of one --together" diff -rq together snake/seamless
fi

# ---- Dask: workers are killed while they work
python=/usr/bin/python3
if engine "Dask (distributed)" $python -c 'import distributed'; then
    export PYTHONPATH=$farm/dask PYTHONDONTWRITEBYTECODE=1
    $python "$farm/dask/norma_dask.py" check "my models" dask.json >dask.log 2>&1
    same_report Dask $? dask.json
    cat >killing_dask.py <<'END'
import os, random, signal, sys, threading, time
import dask
from distributed import Client, LocalCluster
import norma_dask

if __name__ == "__main__":
    dask.config.set({"distributed.scheduler.allowed-failures": 20})
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, Client(cluster) as client:
        killed, ended = [], threading.Event()

        def kill():
            random.seed(1)
            while not ended.wait(1.0) and len(killed) < 3:
                known = set(cluster.scheduler.workers) # of one that dies while it starts, the nanny may start no other
                alive = [nanny.pid for nanny in cluster.workers.values() if nanny.pid and nanny.worker_address in known]
                if alive:
                    pid = random.choice(alive)
                    os.kill(pid, signal.SIGKILL)
                    killed.append(pid)

        thread = threading.Thread(target=kill)
        thread.start()
        rounds = 0
        while rounds < 1 or len(killed) < 2:  # on a fast machine, the work must not end before
            done = norma_dask.seams(client, "my tiles", "dask", in_job=4, fan=4)
            rounds += 1
        ended.set()
        thread.join()
        print("%d tiles, %d workers killed" % (done, len(killed)))
        sys.exit(done != 144 or len(killed) < 2)
END
    check "Dask: workers are killed, and all tiles are done" timeout 300 $python killing_dask.py
    check "Dask: the bits of one --together" diff -rq together dask
    mkdir empty
    check "Dask: a folder without tiles is an error" bash -c "! $python '$farm/dask/norma_dask.py' seams empty none 2>said && grep -qx 'empty: holds no PLY file' said && [ ! -e none ]"
    check "Dask: a tile that cannot be read is an error" bash -c "! $python '$farm/dask/norma_dask.py' seams 'my tiles/below' none 2>said && grep -q 'norma seams votes: status' said"
    check "Dask: nothing else is left" bash -c '! ls -d tmp* 2>/dev/null'
fi

# ---- Slurm: a cluster of this machine, with daemons of its own
if engine Slurm bash -c 'command -v slurmctld slurmd sbatch' && { [ "$(id -u)" = 0 ] || { skip "Slurm's daemons need root here"; false; }; }; then
    mkdir -p slurm/state slurm/spool
    host=$(hostname -s)
    cat >slurm/slurm.conf <<END
ClusterName=farm
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=17817
SlurmdPort=17818
AuthType=auth/none
CredType=cred/none
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$scratch/slurm/state
SlurmdSpoolDir=$scratch/slurm/spool
SlurmctldPidFile=$scratch/slurm/ctld.pid
SlurmdPidFile=$scratch/slurm/d.pid
SlurmctldLogFile=$scratch/slurm/ctld.log
SlurmdLogFile=$scratch/slurm/d.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=1
MinJobAge=60
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
    export SLURM_CONF=$scratch/slurm/slurm.conf
    slurmctld -D >slurm/ctld.out 2>&1 &
    controller=$!
    slurmd -D >slurm/d.out 2>&1 &
    daemon=$!
    for _ in $(seq 60); do sinfo -h -o %T 2>/dev/null | grep -q idle && break; sleep 0.5; done
    if check "Slurm's node is idle" bash -c 'sinfo -h -o %T | grep -q idle' && sinfo -h -o %T 2>/dev/null | grep -q idle; then
        "$farm/slurm/submit.sh" "my models" 5 slurm.json >slurm.log 2>&1
        same_report Slurm $? slurm.json
    fi
    kill $daemon $controller 2>/dev/null
    wait $daemon $controller 2>/dev/null
fi
finish
