"""Frames per second of decoding plus detection against decoding alone, side by side in one run.

    python benchmarks/detection.py [--sizes 1080p 2.7K 4K] [--codecs h264 hevc] [--frames 240]
    python benchmarks/detection.py --memory [--sizes 1080p] [--codecs h264]

Clips are rendered (cached in --folder) at the bit rates of the camera: 60 Mbit/s, 100 at 4K, one
reference frame, a key frame every 15. Every clip is decoded, then decoded with detection, in turn,
`--rounds` times; the medians are compared. Exits with 1 where a ratio is under the bar.
With `--memory` the greatest memory of detection in a clip is held against that in the same clip six
times over.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import av
import numpy as np

from bluekoi.footage import frames, open_recording
from bluekoi.keypoints import silhouette
from bluekoi.study import Study, Trial, load_study
from bluekoi.synthetic.picture_conditions import MIDDLE_PICTURE_CONDITIONS
from bluekoi.synthetic.study_rendering import render_study
from bluekoi.synthetic.synthetic_study_design import picture_conditions_design

MIN_SPEED_RATIO = 0.93
MAX_MEMORY_MB = 600
MAX_MEMORY_GROWTH_MB = 20
SIZES = {"1080p": ((1920, 1080), 60.0), "2.7K": ((2704, 1520), 60.0), "4K": ((3840, 2160), 100.0)}


def render_clip(folder: Path, size: str, codec: str, count: int) -> Path:
    """Study folder of one rendered clip, made where it is not there yet."""
    study = folder / f"{size}-{codec}-{count}"
    if (study / "truth.sha256").exists():
        return study
    size_px, rate = SIZES[size]
    state = replace(
        MIDDLE_PICTURE_CONDITIONS, size_px=size_px, mbit_s=rate, codec=codec, preset="superfast"
    )
    design = picture_conditions_design(state, longest_s=count / 29.97)
    design = replace(design, plans=design.plans[1:2])
    render_study(design, study, folder / f"{study.name}-truth", workers=1)
    return study


def time_task(task: Callable[[], int]) -> tuple[float, float]:
    """Wall and processor seconds of a task."""
    wall, cpu = time.perf_counter(), time.process_time()
    task()
    return time.perf_counter() - wall, time.process_time() - cpu


def compare_speeds(study: Study, trial: Trial, rounds: int) -> dict[str, float]:
    """Medians over rounds of decoding alone and of decoding with detection."""
    paths = study.paths(trial)

    def decode() -> int:
        return sum(1 for _ in frames(open_recording(paths)))

    def detect() -> int:
        recording = open_recording(paths)
        found = silhouette.detect_keypoints(lambda: frames(recording), study.setup, trial)
        return len(found.time_s)

    count = detect()
    pairs = [(time_task(decode), time_task(detect)) for _ in range(rounds)]
    table = np.array(pairs)
    alone, both = np.median(table, axis=0)
    ratios = table[:, 0] / table[:, 1]
    return {
        "frames": count,
        "alone_fps": count / alone[0],
        "both_fps": count / both[0],
        "alone_cpu_ms": 1e3 * alone[1] / count,
        "both_cpu_ms": 1e3 * both[1] / count,
        "wall_ratio": float(np.median(ratios[:, 0])),
        "cpu_ratio": float(np.median(ratios[:, 1])),
    }


def print_comparison(study: Path, rounds: int) -> bool:
    """Print a line for one study's first trial; whether both bars are met."""
    loaded = load_study(study)
    row = compare_speeds(loaded, loaded.trials[0], rounds)
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{study.name:>16} {row['frames']:5.0f} frames  decode {row['alone_fps']:6.1f} fps "
        f"({row['alone_cpu_ms']:5.1f} CPU ms)  with detection {row['both_fps']:6.1f} fps "
        f"({row['both_cpu_ms']:5.1f} CPU ms)  ratio {row['wall_ratio']:.3f} wall "
        f"{row['cpu_ratio']:.3f} CPU  {megabytes:4.0f} MB",
        flush=True,
    )
    return row["wall_ratio"] >= MIN_SPEED_RATIO and megabytes < MAX_MEMORY_MB


def repeat_clip(study: Path, times: int) -> Path:
    """Study folder of a clip whose packets are repeated, made where it is not there yet."""
    longer = study.with_name(f"{study.name}-times-{times}")
    if (longer / "done").exists():
        return longer
    shutil.copytree(study, longer, dirs_exist_ok=True)
    trial = load_study(study).trials[0]
    source, target = study / trial.source, longer / trial.source
    with av.open(str(target), "w") as out:
        template = av.open(str(source)).streams.video[0]
        stream = out.add_stream_from_template(template)
        for turn in range(times):
            with av.open(str(source)) as film:
                own = film.streams.video[0]
                for packet in (p for p in film.demux(own) if p.dts is not None):
                    packet.stream = stream
                    packet.pts, packet.dts = (
                        at + turn * (own.duration or 0) for at in (packet.pts, packet.dts)
                    )
                    out.mux(packet)
    (longer / "done").touch()
    return longer


def max_memory_mb(study: Path) -> float:
    """Greatest memory of a process that detects in a study's first trial, MB."""
    command = [sys.executable, __file__, "--study", str(study), "--memory"]
    reported = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return float(reported.split()[0])


def detect_and_report_memory(study: Path) -> str:
    """Megabytes and frames of one detection in this process."""
    loaded = load_study(study)
    recording = open_recording(loaded.paths(loaded.trials[0]))
    found = silhouette.detect_keypoints(lambda: frames(recording), loaded.setup, loaded.trials[0])
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return f"{megabytes:.1f} MB, {len(found.time_s)} frames"


def print_memory(study: Path, times: int = 6) -> bool:
    """Print the memory of a clip and of a longer one; whether it hardly grows."""
    short, long = (max_memory_mb(one) for one in (study, repeat_clip(study, times)))
    print(f"{study.name:>16} {short:5.0f} MB; {times} times as long: {long:5.0f} MB", flush=True)
    return long < short + MAX_MEMORY_GROWTH_MB and long < MAX_MEMORY_MB


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", nargs="+", default=list(SIZES), choices=list(SIZES))
    parser.add_argument("--codecs", nargs="+", default=["h264", "hevc"])
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument(
        "--folder", type=Path, default=Path(tempfile.gettempdir()) / "bluekoi-clips"
    )
    parser.add_argument("--study", type=Path, help="measure this study's first trial alone")
    parser.add_argument("--memory", action="store_true", help="memory against length")
    options = parser.parse_args()
    if options.study and options.memory:
        print(detect_and_report_memory(options.study))
        return 0
    if options.study:
        return 0 if print_comparison(options.study, options.rounds) else 1
    failed = 0
    for size in options.sizes:
        for codec in options.codecs:
            study = render_clip(options.folder, size, codec, options.frames)
            if options.memory:
                failed += not print_memory(study)
                continue
            command = [sys.executable, __file__, "--study", str(study)]
            command += ["--rounds", str(options.rounds)]
            failed += subprocess.run(command, check=False).returncode
    print(f"bar {MIN_SPEED_RATIO} of decoding alone and {MAX_MEMORY_MB} MB: {failed} clips miss it")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
