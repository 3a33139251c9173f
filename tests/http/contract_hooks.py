"""contract_hooks.py - what schemathesis cannot know from the contract: names that exist.

Loaded by schemathesis itself ($SCHEMATHESIS_HOOKS), in test_contract.py's runs. $CONTRACT_JOB is a
job that is done, $CONTRACT_PATCHED one that patches may have paused or at work for long,
$CONTRACT_SCENE a scene. Requests that are meant to be in order are led to these;
those that are meant to be at fault stay as they are.
"""
import hashlib
import os

import schemathesis

JOB, PATCHED = os.environ["CONTRACT_JOB"], os.environ["CONTRACT_PATCHED"]
SCENE = os.environ["CONTRACT_SCENE"]

schemathesis.serializer.alias(["application/merge-patch+json", "model/gltf+json"],
                              "application/json")
schemathesis.serializer.alias(["model/gltf-binary", "model/obj", "model/stl", "application/ply"],
                              "application/octet-stream")


def meant_in_order(case):
    return case.meta is not None and case.meta.generation.mode.is_positive


def leave_the_choice(job):
    """Who gives a budget and settings may ask for what no point of the front reaches."""
    accuracy = job.get("accuracy")
    budget = {"time", "error"} & set(accuracy) if isinstance(accuracy, dict) else None
    if budget:
        job["accuracy"] = {name: accuracy[name] for name in budget}
        job.pop("live", None)
        job.pop("max_bounces", None)


def lead(case):
    """A request that the contract allows, to things that exist."""
    label = case.operation.label
    parameters = case.path_parameters or {}
    if "id" in parameters:
        parameters["id"] = JOB
    if "scene" in parameters and case.operation.method.upper() == "GET":
        parameters["scene"] = SCENE
    if label == "POST /v1/jobs" and isinstance(case.body, dict):
        case.body["scene"] = SCENE
        # What refers to the scene, to the resolution, to each other.
        for reference in ("camera", "animation", "region", "sample_range", "mattes", "adaptive", "estimate"):
            case.body.pop(reference, None)
        case.body["resolution"] = [16, 12]
        leave_the_choice(case.body)
        outputs = case.body.get("outputs")
        if isinstance(outputs, list) and "matte_sums" in outputs and "crypto_object" not in outputs:
            outputs.append("crypto_object")  # whose sums they are
        if isinstance(case.body.get("shutter"), list):
            case.body["shutter"].sort()  # it opens before it closes
        case.body["stop"] = {"samples": 1}
    if label == "PUT /v1/assets/{sha256}" and isinstance(case.body, (bytes, str)):
        body = case.body if isinstance(case.body, bytes) else case.body.encode()
        parameters["sha256"] = hashlib.sha256(body).hexdigest()
    if label == "PATCH /v1/jobs/{id}":
        parameters["id"] = PATCHED
        if isinstance(case.body, dict):
            case.body.pop("camera", None)  # the job is not live
    if label.endswith(("/frame.png", "/matte.exr", "/matte.png")) and case.query:
        case.query.pop("through", None)  # whose classes a job chooses
    if label.endswith("/pick"):
        case.query.update(x=3, y=4)
    for choice, value in [("after", JOB), ("outputs", "beauty"), ("output", "beauty"), ("name", ["ball"])]:
        if choice in (case.query or {}):
            case.query[choice] = value
    for condition in ("If-Match", "If-None-Match", "If-Range", "Idempotency-Key"):
        if case.headers:
            case.headers.pop(condition, None)


def spare_the_scene(case):
    """What follows from an answer may name it; it is to stay as it is."""
    parameters = case.path_parameters or {}
    if case.operation.method.upper() != "GET" and parameters.get("scene") == SCENE:
        parameters["scene"] = "another"


@schemathesis.hook
def before_call(context, case, **kwargs):
    spare_the_scene(case)
    if meant_in_order(case):
        lead(case)
