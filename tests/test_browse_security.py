"""What the server of the pages refuses: each attack is tried by hand, and none gets what lies outside the archive."""

import json
import os
import shutil
import subprocess

import h5py
import numpy as np
import pytest
from archived_files import edited
from browse_client import Client, serving

from tribopipe.browse import app
from tribopipe.browse.guard import REPORT_POLICY
from tribopipe.browse.responses import download

SECRET = b"secret 4711"
RUN = "si3n4-air-200mN"
H5_ROUTES = ("attr", "data", "meta", "stats", "paths")
REACHING_OUT = (
    "/external",
    "/external_group",
    "/external_group/text",
    "/to_external",
    "/to_external_group/numbers",
    "/stored",
    "/to_stored",
    "/virtual",
    "/endless_virtual",
    "/to_virtual",
    "/group/external",
    "/group/back/external",
)


@pytest.fixture(scope="module")
def place(_processed, tmp_path_factory):
    """An archive with one good run, beside it secrets, and in it files that reach for them."""
    outside = tmp_path_factory.mktemp("lab")
    folder = outside / "archive"
    shutil.copytree(_processed, folder)
    (outside / "secret.txt").write_bytes(SECRET)
    with h5py.File(outside / "secret.h5", "w") as file:
        file["text"] = np.frombuffer(SECRET, dtype=np.uint8)
        file["numbers"] = np.full(10, 4711.0)
        file["endless"] = file.create_dataset("grows", data=np.full(10, 4711.0), maxshape=(None,))
    shutil.copy(outside / "secret.h5", outside / f"{RUN}.h5")
    _write_reaching(folder / "reaching.h5")
    _write_greedy(folder / "greedy.h5")
    for name, spoil in {"linked": _link_depth, "stored": _store_source, "virtual": _make_virtual}.items():
        shutil.copy(folder / f"{RUN}.h5", folder / f"{name}.h5")
        with edited(folder / f"{name}.h5") as file:
            spoil(file["entry"])
    return folder


def _write_reaching(path):
    with h5py.File(path, "w") as file:
        file["own"] = np.arange(3.0)
        file["external"] = h5py.ExternalLink("../secret.h5", "/text")
        file["external_group"] = h5py.ExternalLink("../secret.h5", "/")
        file.create_dataset("stored", (len(SECRET),), dtype="u1", external=[("../secret.txt", 0, len(SECRET))])
        for name, kept in {"virtual": "numbers", "endless_virtual": "grows"}.items():
            endless = (h5py.h5s.UNLIMITED,) if name == "endless_virtual" else None
            layout = h5py.VirtualLayout((10,), dtype=float, maxshape=endless)
            source = h5py.VirtualSource("../secret.h5", kept, shape=(10,), maxshape=endless)
            if endless:
                layout[: h5py.h5s.UNLIMITED] = source[: h5py.h5s.UNLIMITED]
            else:
                layout[:] = source
            file.create_virtual_dataset(name, layout)
        group = file.create_group("group")
        group["external"] = h5py.ExternalLink("../secret.h5", "/text")
        group["back"] = group
        group["relative"] = h5py.SoftLink("../own")
        file["loop"] = h5py.SoftLink("/loop")
        file["there"], file["back"] = h5py.SoftLink("/back"), h5py.SoftLink("/there")
        for name in ("external", "external_group", "stored", "virtual"):
            file[f"to_{name}"] = h5py.SoftLink(f"/{name}")
        file["to_own"] = h5py.SoftLink("own")


def _write_greedy(path):
    with h5py.File(path, "w") as file:
        file.create_dataset("endless", (10**12,), dtype=float, chunks=(1 << 16,), compression="gzip")
        file.create_dataset("lump", (1 << 28,), dtype=float, chunks=(1 << 28,), compression="gzip")
        file.create_dataset("two_million", data=np.zeros(2_000_000), compression="gzip")
        file.create_dataset("texts", data=["long " * 20_000] * 7, dtype=h5py.string_dtype())
        file["number"] = 1.5
        file["complex"] = np.array([1 + 2j])
        file.attrs["broken"] = np.bytes_(b"\xff\xfe")
        file["nothing"] = h5py.Empty("f8")


def _link_depth(entry):
    del entry["raw/depth"]
    entry["raw/depth"] = h5py.ExternalLink("../secret.h5", "/numbers")


def _store_source(entry):
    del entry["source_files/file_0/data"]
    size = len(SECRET)
    entry["source_files/file_0"].create_dataset("data", (size,), dtype="u1", external=[("../secret.txt", 0, size)])


def _make_virtual(entry):
    del entry["raw/depth"]
    layout = h5py.VirtualLayout((10,), dtype=float)
    layout[:] = h5py.VirtualSource("../secret.h5", "numbers", shape=(10,))
    entry["raw"].create_virtual_dataset("depth", layout)


@pytest.fixture(scope="module")
def client(place):
    with serving(place) as client:
        yield client


def told(answer):
    """Return the one sentence of a refusal, which gives nothing away."""
    assert SECRET not in answer.body
    assert b"4711" not in answer.body
    assert b"Traceback" not in answer.body
    assert answer.headers["content-type"] == "application/json"
    assert answer.headers["x-content-type-options"] == "nosniff"
    return answer.error


OUT_OF_THE_FOLDER = (
    "../secret.h5",
    "studies/../../secret.h5",
    "..\\secret.h5",
    "%2e%2e/secret.h5",
    "%252e%252e%252fsecret.h5",
    "....//secret.h5",
    "C:\\secret.h5",
    "C:secret.h5",
    "\\\\lab\\share\\secret.h5",
    "//lab/share/secret.h5",
    "file:///secret.h5",
    f"{RUN}.h5\0.h5",
    "~/secret.h5",
    "",
    ".",
    "catalogue.sqlite",
)


@pytest.mark.parametrize("name", OUT_OF_THE_FOLDER)
@pytest.mark.parametrize("route", H5_ROUTES)
def test_no_hdf5_file_outside_the_folder_is_opened(client, route, name):
    answer = client.get("h5", route, file=name, path="/")
    assert answer.status == 404
    assert "expected" in told(answer)


def test_no_absolute_path_is_opened(client, place):
    secret = place.parent / "secret.h5"
    for name in (secret, secret.as_posix(), secret.as_uri(), place / f"{RUN}.h5"):
        assert client.get("h5", "meta", file=str(name)).status == 404


TRAVERSALS = (
    "/../secret.txt",
    "/../../secret.txt",
    "/%2e%2e/secret.txt",
    "/..%2fsecret.txt",
    "/%2e%2e%2fsecret.txt",
    "/%252e%252e%252fsecret.txt",
    "/..%5csecret.txt",
    "/assets/..%2f..%2fsecret.txt",
    "/assets/../../secret.txt",
    "//secret.txt",
    "/C:%5csecret.txt",
    "/secret.txt%00.js",
)


def test_the_pages_are_served_from_their_folder_alone(client, tmp_path, monkeypatch):
    (tmp_path / "secret.txt").write_bytes(SECRET)
    (tmp_path / "static" / "assets").mkdir(parents=True)
    (tmp_path / "static" / "index.html").write_text("the page", encoding="utf-8")
    (tmp_path / "static" / "assets" / "app.js").write_text("1", encoding="utf-8")
    monkeypatch.setattr(app, "BUNDLE", tmp_path / "static")
    for target in (*TRAVERSALS, (tmp_path / "secret.txt").as_posix(), "/runs/x", "/"):
        answer = client.send(target)
        assert SECRET not in answer.body
        assert (answer.status, answer.body) == (200, b"the page") or answer.status in (400, 404)
    script = client.send("/assets/app.js")
    assert (script.status, script.headers["content-type"].partition(";")[0]) == (200, "text/javascript")
    assert "immutable" in script.headers["cache-control"]


@pytest.mark.parametrize(
    "target",
    [
        f"/api/runs/..%2f{RUN}/file",
        f"/api/runs/..%5c{RUN}/file",
        f"/api/runs/%2e%2e%2f{RUN}",
        f"/api/runs/%252e%252e%252f{RUN}/file",
        "/api/runs/..%2fsecret/file",
        "/api/runs/../../secret.h5",
        "/api/runs/..",
        "/api/runs/C:%5csecret/file",
        "/api/runs/secret%00/file",
        "/api/studies/..%2f..%2fsecret",
        f"/api/studies/..%5c{RUN}",
        "/api/compare/wear?runs=../secret",
        "/api/runs/%ff%fe/file",
    ],
)
def test_no_id_leads_out_of_the_folder(client, target):
    answer = client.send(target)
    assert answer.status in (400, 404)
    told(answer)


def test_a_symbolic_link_out_of_the_folder_is_not_followed(place, client):
    try:
        (place / "away.h5").symlink_to(place.parent / f"{RUN}.h5")
        (place / "lab").symlink_to(place.parent, target_is_directory=True)
        (place / "circle.h5").symlink_to(place / "circle.h5")
    except OSError:
        pytest.skip("this system lets nobody make symbolic links")
    try:
        for route in H5_ROUTES:
            for name in ("away.h5", "lab/secret.h5", "circle.h5"):
                assert client.get("h5", route, file=name).status == 404
        for tail in ((), ("file",), ("sources", "0"), ("plots", "wear"), ("report",), ("csv", "raw")):
            answer = client.get("api", "runs", "away", *tail)
            assert answer.status == 404
            told(answer)
    finally:
        for name in ("away.h5", "lab", "circle.h5"):
            (place / name).unlink()


@pytest.mark.parametrize("path", REACHING_OUT)
@pytest.mark.parametrize("route", H5_ROUTES)
def test_nothing_of_another_file_is_shown(client, route, path):
    answer = client.get("h5", route, file="reaching.h5", path=path)
    assert answer.status in (403, 404)
    told(answer)


def test_links_that_lead_out_are_listed_as_links(client):
    answer = client.get("h5", "meta", file="reaching.h5", path="/")
    kinds = {child["name"]: child["kind"] for child in answer.json["children"]}
    assert kinds["external"] == kinds["external_group"] == "external_link"
    assert kinds["to_external"] == kinds["to_stored"] == kinds["loop"] == "soft_link"
    assert kinds["stored"] == kinds["virtual"] == kinds["endless_virtual"] == "other"
    assert kinds["own"] == kinds["to_own"] == "dataset"
    assert b"4711" not in answer.body


def test_paths_end_where_a_link_leads_out(client):
    paths = client.get("h5", "paths", file="reaching.h5", path="/").json
    assert "/external_group" in paths
    assert not [path for path in paths if path.startswith("/external_group/")]
    assert client.get("h5", "paths", file="reaching.h5", path="/group").json[0] == "/group"


@pytest.mark.parametrize("path", ["/loop", "/there", "/loop/own", "/there/back/there"])
@pytest.mark.parametrize("route", H5_ROUTES)
def test_links_in_circles_come_to_an_end(client, route, path):
    assert client.get("h5", route, file="reaching.h5", path=path).status in (403, 404)


def test_hard_links_in_circles_are_walked_as_far_as_asked(client):
    deep = "/group" + "/back" * 200
    assert client.get("h5", "meta", file="reaching.h5", path=deep).status == 200
    assert client.get("h5", "data", file="reaching.h5", path="/to_own").json == [0.0, 1.0, 2.0]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["linked", "stored", "virtual"])
def test_a_run_that_shows_what_it_does_not_hold_is_refused(client, name):
    for tail in ((), ("plots", "depth"), ("sources", "0"), ("csv", "raw"), ("report",)):
        answer = client.get("api", "runs", name, *tail)
        assert answer.status == 422
        assert "expected only content that tribopipe writes" in told(answer)
    assert client.get("api", "runs").status == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "localhost.evil.example:{port}", "", "[::1]"],
)
def test_another_host_is_refused(client, host):
    answer = client.send("/api/runs", Host=host.format(port=client.port))
    assert answer.status == 400
    assert "expected 127.0.0.1" in told(answer)


@pytest.mark.parametrize("host", ["127.0.0.1:{port}", "localhost:{port}", "LOCALHOST:{port}", "[::1]:{port}"])
def test_its_own_names_are_answered(client, host):
    assert client.send("/api/revision", Host=host.format(port=client.port)).status == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "https://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
        {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors", "Sec_Fetch_Dest": "image"},
        {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "iframe"},
        {"Sec_Fetch_Site": "same-site", "Sec_Fetch_Mode": "cors", "Sec_Fetch_Dest": "empty"},
    ],
)
def test_another_page_is_refused(client, headers):
    answer = client.send("/api/runs", **headers)
    assert answer.status == 403
    assert "expected a request from a page of this server" in told(answer)
    assert not [name for name in answer.headers if name.startswith("access-control")]


def test_its_own_page_and_links_to_it_are_answered(client):
    own = {"Origin": f"http://127.0.0.1:{client.port}", "Sec_Fetch_Site": "same-origin"}
    link = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
    for headers in (own, link, {"Sec_Fetch_Site": "none"}):
        answer = client.send("/api/revision", **headers)
        assert answer.status == 200
        assert not [name for name in answer.headers if name.startswith("access-control")]


@pytest.mark.parametrize("method", ["POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "HEAD", "PROPFIND", "BREW"])
@pytest.mark.parametrize("target", ["/", "/api/runs", f"/api/runs/{RUN}", "/h5/data?file=reaching.h5&path=/own"])
def test_nothing_but_get_is_answered(client, place, method, target):
    before = sorted(path.name for path in place.iterdir())
    answer = client.send(target, method, b"x" * 10)
    assert (answer.status, answer.headers["allow"]) == (405, "GET")
    assert sorted(path.name for path in place.iterdir()) == before


@pytest.mark.parametrize(
    "query",
    [
        {"path": "/endless"},
        {"path": "/endless", "selection": "0:3000000"},
        {"path": "/endless", "selection": "::1"},
        {"path": "/lump", "selection": "0:1"},
    ],
)
@pytest.mark.parametrize("route", ["data", "stats"])
def test_more_than_memory_holds_is_refused(client, route, query):
    answer = client.get("h5", route, file="greedy.h5", **query)
    assert answer.status == 413
    assert "expected at most" in told(answer)


def test_long_texts_are_refused(client, monkeypatch):
    monkeypatch.setattr("tribopipe.browse.h5.LARGEST", 200_000)
    assert client.get("h5", "data", file="greedy.h5", path="/texts").status == 413


def test_two_million_samples_are_not_too_many(client):
    answer = client.get("h5", "data", file="greedy.h5", path="/two_million", format="bin", dtype="safe")
    assert (answer.status, len(answer.body)) == (200, 16_000_000)
    assert client.get("h5", "data", file="greedy.h5", path="/endless", selection="5:9").json == [0.0] * 4


@pytest.mark.parametrize(
    "query",
    [
        {"dtype": "U99999999"},
        {"format": "pickle"},
        {"format": "../csv"},
        {"selection": "0:0:0"},
        {"selection": "9" * 5000},
        {"selection": "-1:"},
        {"selection": ":,:,:,:"},
        {"selection": "__import__('os')"},
        {"selection": "9999999"},
        {"flatten": "perhaps"},
    ],
)
def test_absurd_wishes_are_one_sentence(client, query):
    answer = client.get("h5", "data", file="reaching.h5", path="/own", **query)
    assert answer.status in (200, 400, 422)
    if answer.status != 200:
        told(answer)


@pytest.mark.parametrize("route", H5_ROUTES)
def test_every_kind_of_member_is_an_answer_or_a_sentence(client, route):
    for path in ("/", "/number", "/complex", "/nothing", "/gone", "/number/inside", "//", "/./number"):
        answer = client.get("h5", route, file="greedy.h5", path=path)
        assert answer.status in (200, 404, 422), (route, path, answer.body)
        if answer.status != 200:
            told(answer)


def test_data_of_a_group_are_a_sentence(client):
    answer = client.get("h5", "data", file="reaching.h5", path="/group")
    assert answer.status == 422
    assert "found no dataset at /group" in told(answer)


@pytest.mark.parametrize(
    "query",
    [
        {"width": 10**9},
        {"width": -1},
        {"width": "1e9"},
        {"from_": "nan"},
        {"to": "inf"},
        {"from_": "-Infinity"},
        {"from_": "x"},
        {"width": "9" * 5000},
    ],
)
def test_absurd_windows_are_one_sentence(client, query):
    answer = client.get("api", "runs", RUN, "plots", "wear", **query)
    assert answer.status == 400
    assert len(told(answer)) < 400


def test_every_answer_forbids_scripts_of_others(client):
    for target in ("/", "/api/runs", "/api/nothing", "/h5/meta?file=x", f"/api/runs/{RUN}/sources/0"):
        headers = client.send(target).headers
        policy = dict(part.strip().partition(" ")[::2] for part in headers["content-security-policy"].split(";"))
        assert policy["default-src"] == "'self'"
        assert "script-src" not in policy
        assert policy["frame-ancestors"] == policy["object-src"] == policy["base-uri"] == "'none'"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cross-origin-resource-policy"] == headers["cross-origin-opener-policy"] == "same-origin"
        assert headers["x-content-type-options"] == "nosniff"


def test_there_is_no_page_that_describes_the_server(client):
    for target in ("/docs", "/redoc", "/openapi.json"):
        assert b"swagger" not in client.send(target).body.lower()


SCRIPT = '"><script>alert(1)</script>'


@pytest.fixture
def scripted(archive):
    """An archive whose run has a script in every text that anybody may write."""
    with edited(archive / f"{RUN}.h5") as file:
        manifest = json.loads(file["entry/manifest/data"].asstr()[()])
        manifest |= {"title": SCRIPT, "operator": SCRIPT, "instrument": SCRIPT, "comment": SCRIPT}
        manifest["contact"]["pin"]["material"] = SCRIPT
        file["entry/manifest/data"][()] = json.dumps(manifest)
        file["entry/title"][()] = SCRIPT
        file["entry/source_files/file_0/file_name"][()] = f'run"\r\nSet-Cookie: a=1;{SCRIPT}µ.toml'
    with serving(archive) as client:
        yield client


def test_scripts_in_metadata_are_text(scripted: Client):
    for target in ("/api/archive", "/api/runs", f"/api/runs/{RUN}", f"/h5/data?file={RUN}.h5&path=/entry/title"):
        answer = scripted.send(target)
        assert answer.status == 200
        assert (answer.headers["content-type"], answer.headers["x-content-type-options"]) == (
            "application/json",
            "nosniff",
        )
    assert scripted.get("api", "runs", RUN).json["title"] == SCRIPT


@pytest.mark.slow
def test_a_report_has_no_script_and_may_have_none(scripted: Client):
    answer = scripted.get("api", "runs", RUN, "report")
    assert answer.headers["content-security-policy"] == REPORT_POLICY
    assert "script-src" not in REPORT_POLICY
    assert REPORT_POLICY.startswith("default-src 'none'")
    assert b"<script>alert" not in answer.body


def test_downloads_are_saved_never_shown(scripted: Client):
    answer = scripted.get("api", "runs", RUN, "sources", "0")
    assert answer.headers["content-disposition"].startswith("attachment; ")
    assert answer.headers["content-type"] == "application/octet-stream"
    assert "set-cookie" not in answer.headers
    assert "<" not in answer.headers["content-disposition"]


@pytest.mark.parametrize(
    "name", ['a"b', "a\r\nX: 1", "../../etc/passwd", "..\\..\\boot.ini", "µm \u202egpj.exe", "", "\udcff", "a;b=c"]
)
def test_no_file_name_ends_its_header(name):
    header = download([b""], name).headers["content-disposition"]
    assert header.isascii()
    assert header.isprintable()
    assert header.count('"') == 2
    assert "/" not in header
    assert "\\" not in header


def test_the_archive_is_read_only(client, place):
    before = {path.name: path.stat().st_mtime_ns for path in place.glob("*.h5")}
    beside = {path.name for path in place.iterdir() if path.suffix != ".h5"}
    for target in ("/api/runs", f"/api/runs/{RUN}", f"/api/runs/{RUN}/plots/wear", f"/h5/meta?file={RUN}.h5"):
        assert client.send(target).status == 200
    assert {path.name: path.stat().st_mtime_ns for path in place.glob("*.h5")} == before
    assert {path.name for path in place.iterdir() if path.suffix != ".h5"} <= beside | {"catalogue.sqlite"}


# --- who is let in ---

ASKED = ("/", "/index.html", "/api/runs", f"/api/runs/{RUN}", f"/h5/meta?file={RUN}.h5&path=/", "/no/such/page")


@pytest.mark.parametrize("target", ASKED)
def test_nobody_gets_an_answer_without_the_key(client, target):
    name, _, secret = client.site.headers["Cookie"].partition("=")
    for cookie in ("", f"{name}=", f"{name}={secret[:-1]}", f"other={secret}", f"{name}={secret}x", f"{name}=\xe9"):
        for key in ("", "key=", "key=x", "key=%FF", f"key={secret[:-1]}"):
            refused = client.send(f"{target}{'&' if '?' in target else '?'}{key}", Cookie=cookie)
            assert refused.status == 401
            assert secret not in refused.body.decode()
            assert "the address printed by `tribopipe browse`" in told(refused)


def test_the_key_moves_from_the_address_into_a_cookie(client):
    _, _, secret = client.site.headers["Cookie"].partition("=")
    let_in = client.send(f"/runs/a%20b?key={secret}&tab=wear&x=1%262", Cookie="")
    assert (let_in.status, let_in.headers["location"]) == (303, "/runs/a%20b?tab=wear&x=1%262")
    cookie, *attributes = let_in.headers["set-cookie"].split("; ")
    assert cookie == f"tribopipe-{client.port}={secret}"
    assert {one.lower() for one in attributes} == {"path=/", "httponly", "samesite=lax"}
    assert client.send("/", Cookie=cookie).status == 200


@pytest.mark.parametrize("path", ["//lab.example/", "/\\lab.example/", "///lab.example", "/%2F/lab.example"])
def test_nobody_is_led_elsewhere(client, path):
    _, _, secret = client.site.headers["Cookie"].partition("=")
    let_in = client.send(f"{path}?key={secret}")
    assert let_in.status == 303
    assert not let_in.headers["location"].startswith(("//", "/\\", "http"))


def test_what_a_browser_is_started_with_lets_in_once(client):
    once = client.site.key.address_for_once("/")
    assert client.site.headers["Cookie"].partition("=")[2] not in once
    assert [client.send(once, Cookie="").status for _ in range(3)] == [303, 401, 401]


@pytest.mark.slow
def test_each_server_has_a_key_of_its_own(client, place):
    with serving(place) as other:
        assert other.send("/", Cookie=client.site.headers["Cookie"]).status == 401
        assert other.send("/").status == 200


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can be another account")
def test_another_account_is_refused(client):
    code = (
        "import sys, http.client as h; c = h.HTTPConnection('127.0.0.1', int(sys.argv[1])); c.request('GET', '/'); "
        "print(c.getresponse().status)"
    )
    there = {"capture_output": True, "encoding": "utf-8", "cwd": "/", "timeout": 60}
    found = subprocess.run(["/usr/bin/env", "python3", "-S", "-c", code, str(client.port)], user="nobody", **there)
    assert found.stdout.strip() == "401", found.stderr
