"""Every message that the package writes, of library and command line, on one page: to be read in one go."""

import ast
import re
from pathlib import Path

import antires_rs
from tests.support.snapshots import compare

ROOT = Path(antires_rs.__file__).parent
#: Calls that say something, and which of their arguments are said.
SAYING = {"reject": slice(0, 4), "unsuitable": slice(1, 4), "warn": slice(1, 2), "missing_part": slice(1, 3)}
SAYING |= {"bounded": slice(2, 3), "refuse": slice(0, 4), "Unfit": slice(0, 1), "NothingFound": slice(0, 4)}
OF_ERRORS = "UnsuitableDataError", "InvalidInputError", "Refused", "MissingDependencyError"
SAYING |= dict.fromkeys(OF_ERRORS, slice(0, 4))


def source_of(node):
    """Its source, quoted as from Python 3.12 on."""
    return re.sub(r'\bf"([^"]*)"', r"f'\1'", ast.unparse(node))


def said(node, known):
    """A text of the source with what is put into it in braces; of names what they were last given."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(said(part, known) for part in parts)
        case ast.FormattedValue(value=ast.Name(id=name)) if name in known and known[name] is not node:
            return said(known.pop(name), known) or f"{{{name}}}"
        case ast.FormattedValue(value=value):
            return f"{{{source_of(value)}}}"
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return said(left, known) + said(right, known)
        case ast.IfExp(body=one, orelse=other):
            return f"<{said(one, known)} | {said(other, known)}>"
        case ast.Name(id=name) if name in known:
            return said(known[name], {**known, name: ast.Constant(f"{{{name}}}")})
    return f"{{{source_of(node)}}}"


def assigned(nodes):
    """Texts that names are given, line by line, those of ``+=`` added."""
    known = {}
    for node in nodes:
        if isinstance(node, ast.Assign):
            for target in node.targets:
                pairs = [(target, node.value)]
                if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                    pairs = list(zip(target.elts, node.value.elts, strict=False))
                known |= {one.id: value for one, value in pairs if isinstance(one, ast.Name)}
        elif isinstance(node, ast.AugAssign) and getattr(node.target, "id", None) in known:
            known[node.target.id] = ast.BinOp(known[node.target.id], ast.Add(), node.value)
    return known


def messages_of(tree):
    """Place and text of every message of a module."""
    constants = assigned(tree.body)
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            calls = [node for node in ast.walk(function) if isinstance(node, ast.Call)]
            given = [node for node in ast.walk(function) if isinstance(node, ast.Assign | ast.AugAssign)]
            for node in sorted(calls, key=lambda call: call.lineno):
                if (name := getattr(node.func, "id", "")) in SAYING:
                    before = (each for each in given if each.lineno <= node.lineno)
                    known = constants | assigned(sorted(before, key=lambda each: each.lineno))
                    parts = [said(each, dict(known)) for each in node.args[SAYING[name]]]
                    yield function.name, name, " / ".join(parts)


# -- Those of the core and its binding, whose sources are read as text
RUST = ROOT.parents[1] / "rust"
#: What makes an error; what stands in brackets behind it is said.
RAISING = (
    r"Error::(input)\(|Error::(Numerical) \{|check_(memory)\(|(\w+Error)::new_err\(|\b(internal|refuse)\("
)
TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|//[^\n]*|[(\[{]|[)\]}]|,', re.DOTALL)


def arguments(source, start):
    """What stands between commas up to the bracket that closes, and where that is."""
    depth, parts, last = 0, [], start
    for token in TOKEN.finditer(source, start):
        depth += (token[0] in "([{") - (token[0] in ")]}")
        if depth < 0 or (depth == 0 and token[0] == ","):
            parts.append(source[last : token.start()].strip())
            last = token.end()
        if depth < 0:
            break
    return [part for part in parts if part], last


def said_in_rust(part, before):
    """A text of the source with what is put into it in braces; ``before`` is the function up to it."""
    part = re.sub(r"^(\w+: |&|\|\| )+|(\.into\(\)|\.to_string\(\))$", "", " ".join(part.split())).strip()
    if part.startswith('"'):
        return re.sub(r"\\ *", "", part[1:-1])
    if part.startswith("format!("):
        text, *given = arguments(part, len("format!("))[0]
        filled = iter(given)
        return re.sub(r"\{(:[^}]*)?\}", lambda _: f"{{{next(filled)}}}", said_in_rust(text, before))
    if part.isidentifier() and (given := re.findall(rf"let {part}(?:: [^=]*)? = ([^;]*);", before)):
        return said_in_rust(given[-1], "")
    return f"{{{part}}}"


def messages_in_rust(source):
    """Function, kind and text of every error that a file makes."""
    source = source.partition("#[cfg(test)]\nmod")[0]
    for found in re.finditer(RAISING, source):
        name, (parts, end) = next(filter(None, found.groups())), arguments(source, found.end())
        if len(parts) == 1 and parts[0].startswith("("):
            parts, _ = arguments(parts[0], 1)
        if remedy := re.compile(r"\s*\.remedy\(").match(source, end):
            parts += arguments(source, remedy.end())[0]
        *_, before = re.split(r"\bfn (?=\w)", source[: found.start()])
        texts = [said_in_rust(part, before) for part in parts]
        # What only hands on what it was given says nothing.
        handed_on = all(text.strip("{}").isidentifier() for text in texts)
        if not handed_on and not source[: found.start()].endswith("fn "):
            yield re.match(r"\w+", before)[0], name, " / ".join(texts)


def test_all_messages():
    found = {}
    for path in sorted(ROOT.rglob("*.py")):
        for function, name, text in messages_of(ast.parse(path.read_text(encoding="utf-8"))):
            where = f"{path.relative_to(ROOT).as_posix()} {function} {name}"
            found.setdefault(where, {})[" ".join(text.split())] = None
    for path in sorted(RUST.glob("*/src/**/*.rs")):
        for function, name, text in messages_in_rust(path.read_text(encoding="utf-8")):
            where = f"{path.relative_to(RUST).as_posix().replace('/src', '')} {function} {name}"
            found.setdefault(where, {})[text] = None
    lines = {f"{where} {i}": text for where, texts in found.items() for i, text in enumerate(texts, 1)}
    compare(Path(__file__).with_name("messages.txt"), lines)
