"""Answers taken out of notebooks: what comes along, what stays behind, and what is said when that cannot work."""

import ast
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdenoise.classroom import Finding
from mcdenoise.classroom.checking.cells import LARGEST_CODE, MOST_CELLS, lines_of, without_magics
from mcdenoise.classroom.checking.extract import Cell, answer_source, parse_cells, read_cells
from mcdenoise.classroom.checking.statements import statements_of


def extracted(*sources, name="f"):
    return answer_source([Cell(source) for source in sources], name)


def value(*sources, name="f"):
    """What the name is bound to when nothing but its extracted source is run."""
    namespace = {"__name__": "answer"}
    exec(extracted(*sources, name=name), namespace)
    return namespace[name]


def refused(*sources, name="f"):
    with pytest.raises(Finding) as raised:
        extracted(*sources, name=name)
    return str(raised.value)


RUNS = {
    "last definition": (["def f(): return 1", "def f(): return 2", "f()"], 2),
    "helper in another cell": (["def helper(): return 3", "def f(): return helper()"], 3),
    "helper defined later": (["def f(): return helper()", "def helper(): return 4"], 4),
    "recursion": (["def f(n=3): return n * f(n - 1) if n else 1"], 6),
    "mutual recursion": (["def f(n=4): return n == 0 or g(n - 1)", "def g(n): return n > 0 and f(n - 1)"], True),
    "decorator": (["import functools", "@functools.lru_cache\ndef f():\n    return 5"], 5),
    "own decorator": (["def twice(g): return lambda: 2 * g()", "@twice\ndef f(): return 5"], 10),
    "decorator with a helper": (
        ["def d(g): return lambda: h(g())", "@d\ndef f(): return 5", "def h(x): return -x"],
        -5,
    ),
    "tuple": (["(a, b), *c = (1, 2), 3, 4", "def f(): return a + b + sum(c)"], 10),
    "annotated": (["k: float = 2.5\nm: int", "def f() -> float: return k"], 2.5),
    "import alias": (["import numpy as xp, sys", "def f(): return float(xp.sqrt(9))"], 3.0),
    "import from": (["from math import sqrt as root, pi", "def f(): return root(16)"], 4.0),
    "import of a submodule": (["import xml.dom\nimport xml.sax", "def f(): return bool(xml.dom and xml.sax)"], True),
    "star import": (["from math import *", "def f(): return floor(2.5)"], 2),
    "import in the function": (["def f():\n    import math\n    return math.floor(3.5)"], 3),
    "class": (
        [
            "class Box:\n    size = 2\n    def area(self): return self.size ** power",
            "power = 2\ndef f(): return Box().area()",
        ],
        4,
    ),
    "class with a base": (["class A: k = 1", "class B(A): pass", "def f(): return B.k"], 1),
    "default argument": (["n = 3", "def f(k=n): return k", "n = 4"], 3),
    "value at its time": (["n = 3\ntable = [n] * n\nn = 5", "def f(): return table + [n]"], [3, 3, 3, 5]),
    "value made by a function": (
        ["n = 2", "def make(): return n", "table = make()", "n = 9", "def f(): return table"],
        2,
    ),
    "in place": (["n = 1", "n += 2", "n *= n", "def f(): return n"], 9),
    "entry set": (
        ["import numpy as np\nk = np.zeros(3)", "k[1] = 4", "k[2] += 1", "def f(): return k.tolist()"],
        [0, 4, 1],
    ),
    "attribute set": (["def f(): return f.k", "f.k = 6"], 6),
    "if": (["if 1 > 0:\n    def f(): return 7\nelse:\n    def f(): return 8"], 7),
    "if that may not bind": (["def f(): return 1", "if 1 < 0:\n    def f(): return 2"], 1),
    "try": (
        ["try:\n    import no_such_module as m\nexcept ImportError:\n    m = None", "def f(): return m is None"],
        True,
    ),
    "lambda": (["k = 2", "f = lambda x=1: k * x"], 2),
    "function under another name": (["def g(): return 3", "f = g"], 3),
    "comprehension": (["k = 2\nsquares = [k * i for i in range(3)]", "def f(): return squares"], [0, 2, 4]),
    "local names are its own": (
        ["for x in (1, 2): pass", "def f():\n    x = 5\n    return [x for x in (3,)] + [x]"],
        [3, 5],
    ),
    "global": (["k = 1", "def f():\n    global k\n    k += 1\n    return k"], 2),
    "inner function": (["k = 4", "def f():\n    def g(): return k\n    return g()"], 4),
    "several in one line": (["a = 1; b = 2; print(a); c = a + b", "def f(): return c"], 3),
    "several lines": (["table = [\n  1,\n  2,\n]", "def f():\n    '''Two\nlines.'''\n    return table"], [1, 2]),
    "future import later": (["def f(): return 3", "from __future__ import annotations"], 3),
    "annotation nowhere defined": (["from __future__ import annotations", "def f(x: Picture = 3): return x"], 3),
    "line magic": (["%matplotlib inline\ndef f():\n    return 1\n%timeit f()\n!ls -l 'x\nf?\n?f\nf??"], 1),
    "magic in a function": (["def f():\n    %time x = 3\n    return 2"], 2),
    "magic that assigns": (["files = !ls\nx = %timeit -o f()\ndef f(): return 1"], 1),
    "no magic": (["def f():\n    return (17\n      % 10)\n%time f()"], 7),
    "no magic in a text": (["def f():\n    return '''\n%time\n!ls'''"], "\n%time\n!ls"),
    "cell magic": (["%%time\ndef f(): return 4"], 4),
    "cell of another language": (["def f(): return 1", "%%bash\ndef f(): return 2"], 1),
    "cell that is timed": (["def f(): return 1", "%%timeit\ndef f(): return 2"], 1),
    "indented cell": (["    def f():\n        return 3"], 3),
    "syntax error elsewhere": (["def f(): return 1", "x = = 3", "import numpy as np\nf(", "await x\nreturn"], 1),
    "broken cell with the import again": (["import math", "def f(): return math.floor(1.5)", "import math\nx = ("], 1),
    "broken first try": (["def f(:\n return", "def f(): return 2"], 2),
    "broken after the answer": (["def f(): return 1", "x = 1\ndef f(:"], 1),
    "words after the answer": (["def f(): return 1", "from the lecture: f is separable", "f = exp(-d^2) where d"], 1),
    "unfinished after the answer": (["def f(): return 1", "def f():\n    # later"], 1),
    "method": (["cfg = {'two': 1}; cfg.update(two=2)", "def f(): return cfg['two']"], 2),
    "methods": (["k = []\nk.append(2)", "n = 3\nk.append(n)", "n = 4\ndef f(): return k"], [2, 3]),
    "method below": (["k = [1]", "def f(): return k", "k.append(2)"], [1, 2]),
    "method of an element": (
        ["k = [[], {}]\nk[0].append(2)\nk[1].setdefault(0, []).append(1)\ndef f(): return k"],
        [[2], {0: [1]}],
    ),
    "method of a changed variable": (["k = []\nk.append(3)\nk.append(1)\nk.sort()\ndef f(): return k"], [1, 3]),
    "method that binds": (["k = []\nk.append(n := 2)\ndef f(): return n"], 2),
    "method of a module": (
        [
            "try:\n    import math as m\nexcept ImportError:\n    m = None\nm.sqrt(picture)",
            "def f(): return m.floor(1.5)",
        ],
        1,
    ),
    "method of a function": (["def h(): return 1\nh.show(picture)\ndef f(): return h()"], 1),
    "loop below": (["k = 2", "def f(): return k", "for k in (1, 3): print(k)", "with open('x') as k: pass"], 2),
    "loop below of a helper": (["k = 2", "def h(): return k", "def f(): return h()", "for k in (1, 3): pass"], 2),
    "loop below a helper below": (["def f(): return h()", "k = 2\ndef h(): return k", "for k in (1, 3): pass"], 2),
    "helper replaced by the library's": (
        ["import mcdenoise as mcd", "def h(): return 2", "def f(): return h()", "h = mcd.gaussian\nh(3)"],
        2,
    ),
    "helper replaced by way of a variable": (
        [
            "def h(): return 2",
            "def f(): return h()",
            "import mcdenoise as mcd\ns = mcd.capture('dof')",
            "def h(): return s",
        ],
        2,
    ),
    "picture as argument below": (
        ["import mcdenoise as mcd\nk = [2]", "def f(): return k", "k.count(mcd.capture('dof'))"],
        [2],
    ),
    "constant set again below": (["k = 2", "def f(): return k", "k = 3"], 3),
    "module's name below": (["import math", "def f(): return math.floor(2.5)", "math = 3"], 2),
    "shell line of two": (["!git clone x && \\\n  ls\nimport math", "def f(): return math.floor(2.5)"], 2),
    "shell line of three": (["def f():\n    !ls \\\n  -l \\\n 'x\n    return 2\n!ls \\"], 2),
    "help with a semicolon": (["import math\nmath.floor?;\nf?? ;\ndef f(): return math.floor(2.5)"], 2),
    "several in a line beyond ASCII": (
        ["ä = 'größe'; k = len(ä); n = [k,\n 'ß']; print(n)", "def f(): return n"],
        [5, "ß"],
    ),
    "await": (["import asyncio\nawait asyncio.sleep(0)", "def f(): return 3"], 3),
    "plots left behind": (
        ["import matplotlib.pyplot as plt\nplt.show()", "for i in range(3): plt.plot(i)", "def f(): return 1"],
        1,
    ),
    "joint import": (["import numpy as np, matplotlib.pyplot as plt", "def f(): return int(np.abs(-2))"], 2),
    "markdown": (["def f(): return 1"], 1),
    "windows": (["k = 1\r\ndef f():\r\n    return k\r\n"], 1),
    "form feed": (["k = 1\x0c\ndef f():\n    s = 'a\x0cb\u2028'\n    return len(s)"], 4),
    "unicode": (["größe = 3", "def f(): return größe; 'ä'"], 3),
    "given module": (["import mcdenoise.filters.window as w", "k = w.bell", "def f(): return k([3.0], 1e9)"], None),
    "given name": (["from mcdenoise.filters.window import bell", "k = [bell]", "def f(): return len(k)"], 1),
    "given from above": (["from mcdenoise.filters import window", "k = [window]", "def f(): return len(k)"], 1),
    "mcdenoise when called": (["import mcdenoise as mcd", "def f(): return hasattr(mcd, 'gaussian')"], True),
    "reference": (["from mcdenoise.filters.gaussian import gaussian_sums as f"], None),
}


@pytest.mark.parametrize("case", RUNS)
def test_the_extracted_source_runs_to_the_same_value(case):
    sources, expected = RUNS[case]
    answer = value(*sources)
    if expected is not None:
        assert answer() == expected


REFUSED = {
    "nothing": (["x = 1"], "`f` is not in the notebook."),
    "renamed": (
        ["def gaussian_sum(): pass"],
        "`gaussian_sums` is not in the notebook; it has `gaussian_sum`: was it renamed?",
    ),
    "inside": (["def outer():\n    def f(): pass"], "`f` is not in the notebook."),
    "heavy variable": (
        ["import mcdenoise as mcd", "samples = mcd.capture('dof')", "def f(): return samples"],
        "`f` uses the notebook's variable `samples`, which is made with mcdenoise: an answer may use only its arguments",
    ),
    "by way of another variable": (
        ["import mcdenoise as mcd", "s = mcd.capture('dof')\nnoisy = s.radiance[0]", "def f(): return noisy"],
        "the notebook's variable `noisy`, which is made with mcdenoise",
    ),
    "by way of a helper": (
        ["from mcdenoise import capture", "s = capture('dof')", "def h(): return s", "def f(): return h()"],
        "the notebook's variable `s`, which is made with mcdenoise",
    ),
    "by way of a function that is called": (
        ["import mcdenoise as mcd", "def h(): return mcd.capture('dof')", "s = h()", "def f(): return s"],
        "the notebook's variable `s`, which is made with mcdenoise",
    ),
    "loop": (
        ["for k in range(3): pass", "def f(): return k"],
        "the notebook's variable `k`, which is bound by a `for` loop",
    ),
    "with": (["with open('x') as k: pass", "def f(): return k"], "`k`, which is bound by a `with` block"),
    "deleted": (["k = 1", "del k", "def f(): return k"], "`k`, which is bound by a `del`"),
    "walrus": (["print(k := 1)", "def f(): return k"], "`k`, which is bound by a statement of another kind"),
    "answer in a loop": (["for f in (1, 2): pass"], "`f` is bound by a `for` loop: write the answer itself"),
    "the library's own": (
        ["import mcdenoise as mcd\nf = mcd.gaussian"],
        "`f` is made with mcdenoise: write the answer itself",
    ),
    "library as default": (
        ["import mcdenoise as mcd\ndef f(g=mcd.gaussian): pass"],
        "`f` needs mcdenoise while it is defined",
    ),
    "the library's function": (
        ["import mcdenoise as mcd", "def f(x): return mcd.variance_of_mean(x)"],
        "`f` uses mcdenoise.variance_of_mean, which is not there when it is graded: write it yourself",
    ),
    "the library's function by name": (
        ["from mcdenoise import relmse as g", "def f(x): return g(x, x)"],
        "`f` uses mcdenoise.relmse, which is not there when it is graded",
    ),
    "other libraries": (
        ["from scipy import ndimage", "def f(x): return ndimage.blur(x)"],
        "`f` uses the module `scipy`: an",
    ),
    "plots inside": (["import matplotlib.pyplot as plt", "def f(): plt.show()"], "the module `matplotlib.pyplot`"),
    "own modules": (["from .own import g", "def f(): return g()"], "uses the module `.own`"),
    "syntax": (
        ["def f(x):\n    y = x +\n    return y"],
        "the cell of `f` has a syntax error (invalid syntax) in line 2: `y = x +`",
    ),
    "syntax in a second line": (
        ["x = 1\ndef f(:"],
        "the cell of `f` has a syntax error (invalid syntax) in line 2",
    ),
    "syntax of a value": (["f = 0.5.5"], "the cell of `f` has a syntax error"),
    "method with a picture": (
        ["import mcdenoise as mcd", "k = []\nk.append(mcd.capture('dof'))", "def f(): return k"],
        "the notebook's variable `k`, which is made with mcdenoise",
    ),
    "loop between": (["k = 1", "for k in (1, 2): pass", "def f(): return k"], "`k`, which is bound by a `for` loop"),
    "loop below and above": (["for k in (1, 2): pass", "def f(): return k", "for k in (3, 4): pass"], "a `for` loop"),
    "value of a loop below": (
        ["k = 1", "def f(): return t", "for k in (1, 2): pass", "t = k"],
        "`t`, which is bound by a `for` loop",
    ),
    "syntax of a helper": (["def h(:\n  pass", "def f(): return h()"], "the cell of `h` has a syntax error"),
    "null bytes": (["def f():\0 pass"], "the cell of `f` "),
    "nested too deep": (["f = " + "(" * 9000 + ")" * 9000], "the cell of `f` "),
    "nested deep": (["f = " + "-" * 200_000 + "1"], "the cell of `f` cannot be read by Python (MemoryError)."),
    "nested comprehensions": (["f = " + "[" * 60 + "1" + " for a in b]" * 60], "`f` is nested too deeply for Python."),
    "break outside": (
        ["x = 1\ndef f():\n    break"],
        "`f` has a syntax error ('break' outside loop) in line 3: `break`",
    ),
    "return outside": (
        ["def g(): pass\nif 1:\n    f = 1\n    return f"],
        "`f` has a syntax error ('return' outside function) in line 4",
    ),
    "nonlocal": (
        ["if 1:\n    f = 1\n    nonlocal g"],
        "`f` has a syntax error (nonlocal declaration not allowed at module level) in line 3",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_taken_is_said_in_words(case):
    sources, words = REFUSED[case]
    assert words in refused(*sources, name="gaussian_sums" if case == "renamed" else "f")


def test_nothing_but_what_is_needed_comes_along():
    source = extracted(
        "import numpy as np\nimport sys, os",
        "import mcdenoise as mcd\nimage = mcd.capture('dof')\nimage.show()",
        "radius = 3\nunused = [radius]\ndef unused_too(): return unused",
        "# the exercise\ndef f(x):\n    # a comment stays\n    return np.abs(x) + radius\n\nprint(f(1))",
    )
    assert source == (
        "#@ line 1\nimport numpy as np\n#@ line 1\nradius = 3\n"
        "#@ line 2\ndef f(x):\n    # a comment stays\n    return np.abs(x) + radius"
    )


def test_markdown_and_raw_cells_hold_no_code():
    cells = [Cell("def f(): return 1"), Cell("def f(): return 2", kind="markdown")]
    assert "return 1" in answer_source(cells, "f")


def test_needs_without_end_are_given_up(monkeypatch):
    many = "\n".join(f"a{k} = " + " + ".join(f"a{j}" for j in range(max(0, k - 30), k)) for k in range(1, 200))
    assert value("a0 = 1\n" + many, "def f(): return a2")() == 2
    assert extracted("a0 = 1\n" + many, "def f(): return a199").count("#@") == 201
    monkeypatch.setattr("mcdenoise.classroom.checking.extract.MOST", 150)
    assert "`f` needs too much of the notebook around it" in refused("a0 = 1\n" + many, "def f(): return a199")


def test_bindings_passed_over_come_to_an_end(monkeypatch):
    loops = ["for k in (3, 4): pass"] * 5
    assert value("k = 2", "def f(): return k", *loops)() == 2
    monkeypatch.setattr("mcdenoise.classroom.checking.extract.MOST_PASSED_OVER", 4)
    assert "which is bound by a `for` loop" in refused("k = 2", "def f(): return k", *loops)


def test_a_long_cell_is_split_into_lines_once(monkeypatch):
    split = []
    for module in ("cells", "statements"):
        monkeypatch.setattr(
            f"mcdenoise.classroom.checking.{module}.lines_of", lambda text: split.append(text) or lines_of(text)
        )
    source = "a0 = 1\r" + "\r".join(f"a{k} = a{k - 1}; b{k} = 2" for k in range(1, 2000))
    statements, _ = statements_of([Cell(source), Cell(""), Cell(" \n")])
    assert len([one.source for one in statements]) == 3999
    assert len(split) == 2  # for its magics, and for its statements


@given(st.permutations(range(5)), st.integers(0, 2**16))
def test_definitions_in_any_order_give_the_same_value(order, start):
    sources = [
        f"start = {start}",
        "def f(): return twice(step(start))",
        "def step(n): return n + len(NAMES)",
        "def twice(n): return n + n",
        "NAMES = ['p', 'r', 'f', 'c']",
    ]
    assert value(*(sources[k] for k in order))() == 2 * (start + 4)


NAMES = st.sampled_from("abcd")
LINES = st.one_of(
    st.tuples(NAMES, st.integers(0, 9)).map(lambda t: f"{t[0]} = {t[1]}"),
    st.tuples(NAMES, NAMES).map(lambda t: f"{t[0]} += {t[1]}"),
    st.tuples(NAMES, NAMES, NAMES).map(lambda t: f"{t[0]}, {t[1]} = {t[2]}, {t[0]} + 1"),
    st.tuples(NAMES, NAMES).map(lambda t: f"if {t[0]} > 4: {t[1]} = {t[0]} - 1"),
    st.tuples(NAMES, NAMES).map(lambda t: f"def g(): return {t[0]} * 2\n{t[1]} = g()"),
    st.tuples(NAMES, NAMES).map(lambda t: f"{t[0]} = [{t[1]}]\n{t[0]}.append({t[0]}[0] + 1)\n{t[0]} = {t[0]}[1]"),
    st.tuples(NAMES, NAMES).map(lambda t: f"def h(k={t[0]}): return k + {t[1]}\nb = h()"),
)


@given(st.lists(LINES, max_size=12), NAMES, NAMES)
def test_extraction_computes_what_the_whole_notebook_computes(lines, first, second):
    sources = ["a = 1; b = 2\nc = 3\nd = 4", *lines, f"def f(): return {first} - 3 * {second}"]
    namespace = {}
    for source in sources:
        exec(source, namespace)
    assert value(*sources)() == namespace["f"]()


@given(st.text(alphabet="%!?() \n'\"abc=:#\\\tdef", max_size=60))
def test_no_cell_stops_the_others(text):
    assert value("def f(): return 1", text.replace("f", "g"))() == 1
    ast.parse(extracted("def f(): return 1", text.replace("f", "g")))


@given(st.text(max_size=60))
def test_lines_stay_where_they_are_when_magics_go(text):
    assert without_magics(text).count("\n") <= text.replace("\r", "\n").count("\n")


def notebook(tmp_path, content, name="student.ipynb"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())
    return path


def test_a_notebook_is_read_whole(tmp_path):
    cells = [
        {"cell_type": "markdown", "id": "a", "metadata": {}, "source": "Near."},
        {"cell_type": "code", "id": "b", "metadata": {"exercise": "f"}, "source": ["x = 1\n", "y = 2"], "outputs": []},
        {"cell_type": "raw", "source": "def f(): pass"},
        {"cell_type": "code", "metadata": None, "source": ""},
    ]
    path = notebook(tmp_path, "\ufeff".encode() + json.dumps({"nbformat": 4, "cells": cells}).encode())
    assert read_cells(path) == [
        Cell("Near.", "a", "markdown"),
        Cell("x = 1\ny = 2", "b", "code", {"exercise": "f"}),
        Cell("def f(): pass", "cell-2", "markdown"),
        Cell("", "cell-3"),
    ]


BROKEN = {
    "cut off": (b'{"cells": [', "student.ipynb is no whole notebook"),
    "empty": (b"", "student.ipynb is no whole notebook"),
    "nested": (b"[" * 100_000, "student.ipynb is no whole notebook"),
    "huge number": (b'{"cells": ' + b"9" * 5000 + b"}", "student.ipynb is no whole notebook"),
    "format 3": (
        {"nbformat": 3, "worksheets": [{"cells": []}]},
        "is a notebook of the old format 3: open it in Jupyter",
    ),
    "no cells": ({"nbformat": 4}, "student.ipynb is no notebook: it has no list of cells"),
    "a list": ([1, 2], "student.ipynb is no notebook: it has no list of cells"),
    "a cell without source": ({"cells": [{"cell_type": "code"}]}, "student.ipynb: cell 1 has no source text"),
    "a cell of numbers": (
        {"cells": [{"cell_type": "code", "source": [1]}]},
        "student.ipynb: cell 1 has no source text",
    ),
    "a cell that is none": ({"cells": ["x"]}, "student.ipynb: cell 1 has no source text"),
    "Latin-1": ("{'größe'}".encode("latin-1"), r"student.ipynb is not UTF-8 text \(byte 4\): save it again as UTF-8"),
    "many cells": (
        {"cells": [{"cell_type": "code", "source": ""}] * (MOST_CELLS + 1)},
        "student.ipynb has 2001 cells, more than 2000: remove",
    ),
    "much code": (
        {"cells": [{"cell_type": "code", "source": "x" * (LARGEST_CODE + 1)}]},
        "student.ipynb has more than 128 kB of code",
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_notebook_is_said_to_be_one(case, tmp_path):
    content, words = BROKEN[case]
    with pytest.raises(ValueError, match=words):
        read_cells(notebook(tmp_path, content))


def test_files_that_are_no_notebooks(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"gone\.ipynb: there is no such file"):
        read_cells(tmp_path / "gone.ipynb")
    with pytest.raises(ValueError, match=r"answer\.txt must be a notebook .* got '\.txt'"):
        read_cells(notebook(tmp_path, b"", "answer.txt"))
    monkeypatch.setattr("mcdenoise.classroom.checking.cells.LARGEST", 10)
    with pytest.raises(ValueError, match=r"has more than 0 MB: clear the outputs"):
        read_cells(notebook(tmp_path, b"x" * 11))


def test_large_outputs_do_not_matter():
    cell = {"cell_type": "code", "source": "def f(): return 1", "outputs": [{"data": {"image/png": "x" * 5_000_000}}]}
    assert "return 1" in answer_source(parse_cells(json.dumps({"cells": [cell]}), ".ipynb"), "f")


def test_a_percent_script_is_split_as_jupytext_splits_it():
    jupytext = pytest.importorskip("jupytext")
    script = (
        "# ---\n# jupyter:\n#   kernelspec:\n#     display_name: Python 3\n#     name: python3\n# ---\n\n"
        "# %% [markdown]\n# # Near\n#\n# $w$\n\n# %%\nimport numpy as np\n\n"
        '# %% exercise="f" points=2 tags=["a", "b"]\ndef f():\n    # note\n    return 1\n\n\n# %% A title\nf()\n'
    )
    cells = parse_cells(script, ".py")
    expected = jupytext.reads(script, "py:percent").cells
    assert [(one.kind, one.source) for one in cells] == [(one.cell_type, one.source) for one in expected]
    assert cells[2].metadata == {"exercise": "f", "points": 2, "tags": ["a", "b"]}


def test_a_plain_script_is_one_cell():
    assert parse_cells("x = 1\n\ndef f(): return x\n", ".py") == [Cell("x = 1\n\ndef f(): return x", "cell-0")]
    assert parse_cells("\n", ".py") == []


def test_the_extracted_functions_compute():
    blur = value(
        "import numpy as np", "w = np.exp(-np.arange(-1, 2) ** 2 / 2)", "def f(x): return np.convolve(x, w, 'same')"
    )
    np.testing.assert_allclose(blur([0, 1, 0]), np.exp([-0.5, 0, -0.5]))
