"""Runs a whole job through the generated Python client: job.py BASE MESH."""

import io
import json
import sys
import time
import zipfile
from pathlib import Path

from python import Client, models
from python.api.about import list_methods
from python.api.jobs import cancel_job, cancel_jobs, delete_job, get_job, job_events, list_jobs, submit_job
from python.api.results import archive, parameterisation, preview, quad_mesh, report
from python.types import File

base, mesh = sys.argv[1], Path(sys.argv[2])
client = Client(base_url=base, timeout=120, raise_on_unexpected_status=True)


def parsed(response, wanted, kind):
    """The parsed body of an answer that must have this status and type."""
    assert response.status_code in wanted, (response.status_code, response.content[:500])
    assert isinstance(response.parsed, kind), type(response.parsed)
    return response.parsed


def submit(prefer, **spec):
    file = File(payload=io.BytesIO(mesh.read_bytes()), file_name=mesh.name, mime_type="model/obj")
    form = models.JobForm(mesh=[file], spec=models.RemeshRequest.from_dict(spec))
    answer = submit_job.sync_detailed(client=client, body=form, **({"prefer": prefer} if prefer else {}))
    return parsed(answer, (200, 202), models.JobBody)


methods = parsed(list_methods.sync_detailed(client=client), (200,), models.MethodList)
assert any(method.name == "quadcover" for method in methods.methods)

job = submit("wait=60", target={"quads": 400}, tags=["client"])
deadline = time.monotonic() + 120
while job.status in (models.JobStatus.QUEUED, models.JobStatus.RUNNING):
    assert time.monotonic() < deadline, "the job does not end"
    time.sleep(0.2)
    job = parsed(get_job.sync_detailed(job.id, client=client), (200,), models.JobBody)
assert job.status == models.JobStatus.SUCCEEDED, job.problem
assert job.result.certified and job.input_.name == mesh.name, job
assert job.finished_at > job.created_at, "times are times"

told = parsed(report.sync_detailed(job.id, client=client), (200,), models.ReportBody)
assert told.quads.count == job.result.quads > 0

heads = {"obj": b"#", "glb": b"glTF", "ply": b"ply", "usda": b"#usda"}
for name, head in heads.items():
    answer = quad_mesh.sync_detailed(job.id, client=client, format_=models.QuadMeshFormat(name))
    data = parsed(answer, (200,), File).payload.read()
    assert len(data) > 1000 and (data.startswith(head) or name == "obj"), (name, data[:40])
    wanted = f"filename*=UTF-8''Ring%20%C3%A9.quads.{name}"
    assert wanted in answer.headers["content-disposition"], answer.headers
for name in models.ParameterisationFormat:
    data = parsed(parameterisation.sync_detailed(job.id, client=client, format_=name), (200,), File).payload.read()
    assert len(data) > 1000, name
    if name.value == "json":
        assert json.loads(data), "the parameterisation is JSON"
assert parsed(preview.sync_detailed(job.id, client=client, size=128), (200,), File).payload.read(4) == b"\x89PNG"
files = zipfile.ZipFile(parsed(archive.sync_detailed(job.id, client=client), (200,), File).payload)
assert files.testzip() is None and len(files.namelist()) == 8, files.namelist()
events = parsed(job_events.sync_detailed(job.id, client=client), (200,), str)
assert "event: succeeded" in events, events[-300:]

found = list_jobs.sync_detailed(
    client=client, tag=["client", "other"], status=[models.JobStatus.SUCCEEDED, models.JobStatus.FAILED],
    created_after=job.created_at,
)
assert [entry.id for entry in parsed(found, (200,), models.JobList).jobs] == [job.id]

second = submit(None, target={"quads": 3000}, tags=["second"])
assert parsed(cancel_job.sync_detailed(second.id, client=client), (200, 202), models.JobBody).id == second.id
counted = parsed(cancel_jobs.sync_detailed(client=client, tag=["second"]), (200,), models.JobCount)
assert counted.jobs <= 1
for done in (job, second):
    assert delete_job.sync_detailed(done.id, client=client).status_code == 204
    client_problem = get_job.sync_detailed(done.id, client=client)
    assert isinstance(client_problem.parsed, models.ProblemBody) and client_problem.status_code == 404
refused = submit_job.sync_detailed(client=client, body=models.JobForm(mesh=[File(payload=io.BytesIO(b"nothing"))]))
assert refused.status_code == 415 and refused.parsed.type_.endswith("unknown-format"), refused
print(f"python client: {told.quads.count} quads, 7 files, archive, events, list, cancel, delete")
