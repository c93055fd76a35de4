"""Jobs: a plan, its conditions and its output files in one TOML file, for batches without Blender.

`load_job` reads and checks a file, table by table (`Table`; the tables of a job have files of their own), into a `Job`:
a `Plan`, `Settings` and paths. `run_job` forms, fits or closes the shell, writes the sheets and the report together
(`job_files`, `outputs`) with where they come from (`provenance`), and returns the `Shell`. Both command lines run
inputs by `runs`, in processes by `workers`; an `Outcome` says how each ended, and a `Console` tells. Angles are in
degrees, lengths in the units of the mesh, paths relative to the job. `make_job` takes the tables as dictionaries; the
command `cmc job.toml` runs files::

    from pathlib import Path

    from solver.jobs.job import make_job, run_job

    disc = {"kind": "disc", "n": 300, "scale": 5.0}
    job = make_job({"shape": disc, "default": {"tilt": 20}, "size": {"height": 3.0}}, Path("disc.toml"))
    shell = run_job(job)
    assert shell.ok and abs(shell.report.shown.rise - 3.0) < 1e-6
"""
