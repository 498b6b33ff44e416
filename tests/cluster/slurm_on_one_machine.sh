#!/usr/bin/env bash
# Set up Slurm on this one machine (Debian or Ubuntu, as root) and run the demo through it with
# config/profiles/slurm, from rendered footage to the report. Leaves Slurm running; stop it with
# `... stop`. `small` runs three keypoint trials in the demo's stead.
#
#   apt-get install slurm-wlm munge
#   pip install 'bluekoi[slurm]'
#   tests/cluster/slurm_on_one_machine.sh [all | start | demo | small | stop]
#
# No systemd, no database, no cgroups: loopback addresses, munge, proctrack/linuxproc, task/none,
# select/cons_tres with cores and memory.
set -euo pipefail
cd "$(dirname "$0")/../.."
PYTHON=${PYTHON:-.venv/bin/python}
WORK=${WORK:-$(mktemp -d)}
CONF=/etc/slurm/slurm.conf

stop() {
    scontrol shutdown 2>/dev/null || true
}

configure() {
    local cpus memory
    cpus=$(nproc)
    memory=$(awk '/MemTotal/ {print int($2 / 1024 * 0.8)}' /proc/meminfo)
    mkdir -p /etc/slurm
    cat >"$CONF" <<CONFIGURATION
ClusterName=one
SlurmctldHost=localhost(127.0.0.1)
AuthType=auth/munge
SlurmUser=slurm
StateSaveLocation=/var/lib/slurm/slurmctld
SlurmdSpoolDir=/var/lib/slurm/slurmd
SlurmctldLogFile=/var/log/slurm/slurmctld.log
SlurmdLogFile=/var/log/slurm/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
MinJobAge=3600
MpiDefault=none
NodeName=localhost NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=$memory State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONFIGURATION
}

start() {
    install -d -o munge -g munge -m 755 /run/munge
    install -d -o slurm -g slurm /var/log/slurm /var/lib/slurm/slurmctld
    install -d /var/lib/slurm/slurmd
    # munged takes no for an answer from a root folder that others may write to
    pgrep -x munged >/dev/null || su -s /bin/bash munge -c "/usr/sbin/munged --force"
    pgrep -x slurmctld >/dev/null || slurmctld
    pgrep -x slurmd >/dev/null || slurmd -N localhost
    for _ in $(seq 30); do
        srun -n1 -t1 true 2>/dev/null && return
        sleep 1
    done
    echo "Slurm did not come up; see /var/log/slurm" >&2
    sinfo >&2 || true
    exit 1
}

through_slurm() {
    "$PYTHON" -m snakemake --workflow-profile config/profiles/slurm --jobs 4 --cores "$(nproc)" \
        --config "results=$WORK/results" "$@"
}

run_demo() {
    through_slurm "demo_folder=$WORK/demo"
    check "$(tail -n +2 "$WORK/demo/trials.csv" | wc -l)"
    grep -q '"verdict"' "$WORK/results/mismatch.json" || { echo "no verdict" >&2; exit 1; }
}

run_small() {
    PYTHONPATH=tests:. "$PYTHON" - "$WORK" <<'STUDY'
import sys
from dataclasses import replace
from pathlib import Path

from small_studies import published_model_design
from validation.tracking_noise import keypoint_study

design, root = published_model_design(), Path(sys.argv[1])
plans = tuple(p for p in design.plans if p.trial_id in ("T09", "T10", "T11"))
keypoint_study(replace(design, plans=plans), root / "study", root / "truth")
STUDY
    through_slurm "study=$WORK/study"
    check 3
}

check() {
    local trials=$1 jobs
    jobs=$(squeue --noheader --states=COMPLETED | wc -l)
    [ -s "$WORK/results/report.html" ] || { echo "no report.html" >&2; exit 1; }
    [ "$(tail -n +2 "$WORK/results/steady.csv" | wc -l)" = "$trials" ] ||
        { echo "not $trials trials" >&2; exit 1; }
    [ "$jobs" -gt 0 ] || { echo "nothing went through Slurm" >&2; exit 1; }
    echo "report at $WORK/results/report.html; $jobs jobs went through Slurm"
}

case "${1:-all}" in
    start)
        configure
        start
        ;;
    demo) run_demo ;;
    small) run_small ;;
    stop) stop ;;
    all)
        configure
        start
        run_demo
        ;;
    *) echo "usage: $0 [all | start | demo | small | stop]" >&2; exit 2 ;;
esac
