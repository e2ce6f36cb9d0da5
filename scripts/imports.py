"""Circles of imports: files, or folders, of a crate that need each other; verbs of the command that need another verb; examples that
import another one. None may be; `make lint` runs this.

    python scripts/imports.py
"""

import ast
import re
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CRATES = ["src", "preprocessor/src", "command/src", "validation/src"]
IMPORT = re.compile(r"(?P<public>\bpub(\(\w+\))? )?\buse (?P<tree>[^;]+);")
VERB = re.compile(r"^ +\w+\((\w+)::\w+\),$", re.M)
EXAMPLE = re.compile(r"examples\.(drivelines\.)?\w+")
PATH = re.compile(r"(?<![\w:])(?:[a-z_]\w*::)+\w+")


def paths(tree, stem=""):
    """All paths of a use tree: `a::{b, c::{d}}` gives a::b and a::c::d."""
    head, brace, body = tree.partition("{")
    if not brace:
        return [stem + re.split(r"\bas\b", tree)[0].strip()]
    parts, depth = [""], 0
    for c in body[: body.rindex("}")]:
        depth += (c == "{") - (c == "}")
        if c == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += c
    return [path for part in parts if part.strip() for path in paths(part, stem + head.strip())]


def modules(source):
    """Code of all modules that are not tests, without comments, by their paths: () is the crate's root."""
    found = {}
    for file in sorted(source.rglob("*.rs")):
        parts = file.relative_to(source).with_suffix("").parts
        if any(part == "tests" or part.endswith("_tests") for part in parts):
            continue
        text = re.split(r"#\[cfg\(test\)\]\s+mod ", file.read_text())[0]
        name = parts[:-1] if parts[-1] in ("mod", "lib") or parts == ("main",) and not (source / "lib.rs").exists() else parts
        found[name] = re.sub(r"//.*", "", text)
    return found


def resolve(path, at, code, exports):
    """The module that declares the item of `path`, written in the module `at`; None outside the crate."""
    names = path.split("::")
    here = {"crate": (), "self": at, "super": at[:-1]}.get(names[0])
    if here is None:
        here, names = at, [""] + names
        if at + (names[1],) not in code:
            return None
    for name in names[1:]:
        if name == "super":
            here = here[:-1]
        elif here + (name,) in code:
            here += (name,)
        else:
            return exports.get((here, name), here)
    return here


def imports(code):
    """Modules that each module needs; a module that a parent only publishes is not needed by it."""
    exports, needs = {}, {}
    trees = {at: list(IMPORT.finditer(text)) for at, text in code.items()}
    for at in sorted(code, key=len, reverse=True):
        for path in (path for use in trees[at] if use["public"] for path in paths(use["tree"])):
            target = resolve(path, at, code, exports)
            if target is not None and target != at:
                exports[at, path.rsplit("::")[-1]] = target
    for at, text in code.items():
        named = [path for use in trees[at] if not use["public"] for path in paths(use["tree"])]
        named += PATH.findall(IMPORT.sub("", text))
        needs[at] = {resolve(path, at, code, exports) for path in named} - {None, at}
    return needs


def circle(needs):
    try:
        TopologicalSorter(needs).prepare()
    except CycleError as error:
        return error.args[1]
    return None


def borrowed():
    """Each import of one example by another."""
    for file in sorted((ROOT / "examples").rglob("*.py")):
        at = ".".join(file.relative_to(ROOT).with_suffix("").parts)
        for node in ast.walk(ast.parse(file.read_text())):
            level, module = getattr(node, "level", 0), getattr(node, "module", None)
            stem = at.rsplit(".", level)[0] if level else None
            for alias in node.names if isinstance(node, (ast.Import, ast.ImportFrom)) else []:
                other = EXAMPLE.match(".".join(filter(None, (stem, module, alias.name))))
                if other and other[0] not in (EXAMPLE.match(at)[0], "examples.shared"):
                    yield f"{file.relative_to(ROOT)} imports {other[0]}; what examples share is in examples/shared"


def main():
    found = list(borrowed())
    for crate in CRATES:
        code = modules(ROOT / crate)
        needs = imports(code)
        folders = {}
        for at, others in needs.items():
            folders.setdefault(at[:1], set()).update({other[:1] for other in others} - {at[:1]})
        for graph, kind in [(needs, "files"), (folders, "folders")]:
            if names := circle(graph):
                found.append(f"{crate}: circle of {kind}: " + " <- ".join("/".join(name) or "root" for name in names))
        verbs = {(verb,) for verb in VERB.findall(code[()])}
        found += [f"{crate}: {verb} imports {other}" for (verb,) in verbs for (other,) in folders.get((verb,), set()) & verbs]
    if found:
        sys.exit("\n".join(found))


if __name__ == "__main__":
    main()
