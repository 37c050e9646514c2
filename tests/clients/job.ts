// Runs a whole job through a client on the generated types: job.js BASE MESH.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";
import { basename } from "node:path";
import createClient from "openapi-fetch";
import type { components, paths } from "./api.js";

const [base, mesh] = process.argv.slice(2);
const client = createClient<paths>({ baseUrl: base });

type Job = components["schemas"]["JobBody"];
type Form = components["schemas"]["JobForm"];

/** The data of an answer that must be a success. */
function data<T>(answer: { data?: T; error?: unknown; response: Response }): T {
  assert.ok(answer.data !== undefined, `${answer.response.status}: ${JSON.stringify(answer.error)}`);
  return answer.data;
}

async function submit(spec: Form["spec"], prefer?: string): Promise<Job> {
  const bytes = await readFile(mesh);
  return data(await client.POST("/v1/jobs", {
    params: { header: prefer === undefined ? {} : { Prefer: prefer } },
    body: { mesh: [""], spec },
    // Files are no strings: the form is put together here, from the typed fields.
    bodySerializer(body) {
      const form = new FormData();
      form.append("mesh", new Blob([bytes]), basename(mesh));
      if ("spec" in body) form.append("spec", JSON.stringify(body.spec));
      return form;
    },
  }));
}

const methods = data(await client.GET("/v1/methods"));
assert.ok(methods.methods.some((method) => method.name === "quadcover"));

let job = await submit({ target: { quads: 400 }, tags: ["client"] }, "wait=60");
const path = { id: job.id };
for (let waited = 0; job.status === "queued" || job.status === "running"; waited += 200) {
  assert.ok(waited < 120_000, "the job does not end");
  await new Promise((done) => setTimeout(done, 200));
  job = data(await client.GET("/v1/jobs/{id}", { params: { path } }));
}
assert.equal(job.status, "succeeded", JSON.stringify(job.problem));
assert.ok(job.result?.certified);
assert.equal(job.input.name, basename(mesh));

const report = data(await client.GET("/v1/jobs/{id}/report", { params: { path } }));
assert.equal(report.quads.count, job.result.quads);

for (const format of ["obj", "glb", "ply", "usda"] as const) {
  const answer = await client.GET("/v1/jobs/{id}/quad-mesh", {
    params: { path, query: { format } },
    parseAs: "arrayBuffer",
  });
  assert.ok(data(answer).byteLength > 1000, format);
  const name = answer.response.headers.get("content-disposition");
  assert.ok(name?.includes(`filename*=UTF-8''Ring%20%C3%A9.quads.${format}`), String(name));
}
for (const format of ["obj", "glb", "json"] as const) {
  const answer = await client.GET("/v1/jobs/{id}/parameterisation", {
    params: { path, query: { format } },
    parseAs: "arrayBuffer",
  });
  assert.ok(data(answer).byteLength > 1000, format);
}
const picture = await client.GET("/v1/jobs/{id}/preview.png", { params: { path }, parseAs: "blob" });
assert.ok(data(picture).size > 1000);
const archive = await client.GET("/v1/jobs/{id}/archive.zip", { params: { path }, parseAs: "arrayBuffer" });
assert.equal(Buffer.from(data(archive)).subarray(0, 4).toString("latin1"), "PK\x03\x04");

const events = await client.GET("/v1/jobs/{id}/events", { params: { path }, parseAs: "text" });
assert.match(data(events) ?? "", /event: succeeded/);

const list = data(await client.GET("/v1/jobs", {
  params: { query: { tag: ["client", "other"], status: ["succeeded", "failed"], created_after: job.created_at } },
}));
assert.deepEqual(list.jobs.map((entry) => entry.id), [job.id]);

const second = await submit({ target: { quads: 3000 }, tags: ["second"] });
const cancelled = data(await client.POST("/v1/jobs/{id}/cancel", { params: { path: { id: second.id } } }));
assert.equal(cancelled.id, second.id);
assert.ok(data(await client.POST("/v1/jobs/cancel", { params: { query: { tag: ["second"] } } })).jobs <= 1);
for (const id of [job.id, second.id]) {
  const deleted = await client.DELETE("/v1/jobs/{id}", { params: { path: { id } } });
  assert.equal(deleted.response.status, 204);
  const gone = await client.GET("/v1/jobs/{id}", { params: { path: { id } } });
  assert.equal(gone.error?.type, "urn:quadrille:problem:not-found");
}
console.log(`typescript client: ${report.quads.count} quads, 7 files, archive, events, list, cancel, delete`);
