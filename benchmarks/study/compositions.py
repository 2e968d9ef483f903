"""Error constants of splittings of Riemannian cubics, and their order conditions.

``python -m benchmarks.study.compositions`` prints the table in the documentation of ``SplittingOrder``.

An independent implementation of the flows (exponentials of
block matrices by SciPy) runs every composition on the same random cubics; ``C`` is the error at ``t = 1`` times
``(flows of A per unit of time) ** order``, the error at equal work.
"""

import itertools
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

Matrix = NDArray[np.float64]
State = tuple[Matrix, Matrix, Matrix, Matrix]
Coefficients = tuple[list[float], list[float]]

# Seeds and sizes of the problems: n, k, seed, norm of velocity, acceleration and jerk.
PROBLEMS = [(3, 1, 1, 5.0), (3, 2, 2, 8.0), (5, 2, 3, 6.0), (6, 3, 4, 6.0), (4, 4, 5, 6.0)]

# Numbers of flows of A in the two runs whose errors give the constant and the slope.
WORK = {2: (600, 1000), 4: (240, 400), 6: (120, 180), 8: (84, 108)}
LONG = (300, 420)  # for 15 and more flows per step


def palindrome(half: list[float], length: int) -> list[float]:
    """The palindrome of a given length with the given first half."""
    return [half[min(i, length - 1 - i)] for i in range(length)]


def of_flows(flows: int, a: list[float], b: list[float]) -> Coefficients:
    """First halves of the coefficients of A and B."""
    return palindrome(a, flows), palindrome(b, flows + 1)


def of_strang(weights: list[float], flows: int) -> Coefficients:
    """A symmetric composition of Strang splittings."""
    weights = [*weights, 1 - 2 * sum(weights)]
    a = palindrome(weights, flows)
    return a, [a[0] / 2, *((x + y) / 2 for x, y in itertools.pairwise(a)), a[-1] / 2]


FRACTAL = 1 / (4 - 4 ** (1 / 3))

# fmt: off
COMPOSITIONS: dict[str, tuple[int, list[float], list[float]]] = {
    "Strang (used)": (2, *of_strang([], 1)),
    "Yoshida; Forest and Ruth": (4, *of_strang([1 / (2 - 2 ** (1 / 3))], 3)),
    "Suzuki, fractal": (4, *of_strang([FRACTAL, FRACTAL], 5)),
    "Chin, weights of Simpson": (4, *of_flows(2, [1 / 2], [1 / 6, 2 / 3])),
    "Blanes and Moan S6": (4, *of_flows(6, [.209515106613362, -.143851773179818, .434336666566456],
        [.0792036964311957, .353172906049774, -.0420650803577195, .2193769557534996])),
    "Blanes and Moan SRKN6b": (4, *of_flows(6, [.245298957184271, .60487266571108, -.350171622895351],
        [.0829844064174052, .396309801498368, -.0390563049223486, .1195241940131508])),
    "three flows": (4, *of_flows(3, [0.2746030659947714, 0.4507938680104572],
        [0.08165203919214678, 0.41834796080785325])),
    "four flows (used)": (4, *of_flows(4, [0.2041835327197221, 0.2958164672802779],
        [0.06370219032429467, 0.29415940009693014, 0.2842768191575504])),
    "Yoshida A": (6, *of_strang([.784513610477560, .235573213359357, -1.17767998417887], 7)),
    "Kahan and Li": (6, *of_strang([.39216144400731413928, .33259913678935943860, -.70624617255763935981,
        .08221359629355080023], 9)),
    "Blanes and Moan S10": (6, *of_flows(10,
        [.148816447901042, -.132385865767784, .067307604692185, .432666402578175, -.016404589403618],
        [.0502627644003922, .413514300428344, .0450798897943977, -.188054853819569, .54196067845078,
         -.7255255585086898])),
    "Blanes and Moan SRKN11b": (6, *of_flows(11,
        [.123229775946271, .290553797799558, -.127049212625417, -.246331761062075, .357208872795928, .20477705429147],
        [.0414649985182624, .198128671918067, -.0400061921041533, .0752539843015807, -.0115113874206879,
         .2366699247869311])),
    # It starts with a flow of A: the first and the last flow of B are trivial.
    "Blanes and Moan SRKN14a": (6, *of_flows(15,
        [.0378593198406116, .102635633102435, -.0258678882665587, .314241403071447, -.130144459517415,
         .106417700369543, -.00879424312851058, .2073050690568954],
        [0.0, .09171915262446165, .183983170005006, -.05653436583288827, .004914688774712854, .143761127168358,
         .328567693746804, -.19641146648645423])),
    "four flows, the fewest": (6, *of_flows(4, [1.0798524263824307, -0.5798524263824307],
        [0.3599508087941436, -0.14371472730265406, 0.5675278370170209])),
    "five flows (used)": (6, *of_flows(5, [0.16456352749554009, 0.38243808545051024, -0.09400322589210066],
        [0.046790375052391777, 0.26260778243982274, 0.19060184250778546])),
    "six flows": (6, *of_flows(6, [0.29824930162995383, -0.13004660315258068, 0.3317973015226268],
        [0.04978762464428989, 0.027799939683589805, 0.2551398900486781, 0.3345450912468845])),
    "Yoshida D": (8, *of_strang([.91484424622974, .253693336566229, -1.44485223686048, -.158240635368243,
        1.93813913762276, -1.96061023297549, .102799849391985], 15)),
    "Suzuki and Umeno": (8, *of_strang([.74167036435061295345, -.40910082580003159400, .19075471029623837995,
        -.57386247111608226666, .29906418130365592384, .33462491824529818378, .31529309239676659663], 15)),
    "Kahan and Li, order 8": (8, *of_strang([.13020248308889008088, .56116298177510838456, -.38947496264484728641,
        .15884190655515560090, -.39590389413323757734, .18453964097831570709, .25837438768632204729,
        .29501172360931029887], 17)),
    "ten flows": (8, *of_flows(10,
        [0.11909028269236285, 0.2577641938297826, 0.3353311654240524, -0.3835418589736962, 0.17135621702749831],
        [0.03286958262199065, 0.19778342595724954, 0.35320482752546856, -0.044723922678507486, 0.04801091751306084,
         -0.17428966187852424])),
    "twelve flows (used)": (8, *of_flows(12,
        [0.10536606760856979, 0.21417341062611012, 0.0494182057456452, -0.25534565911385764, 0.19231317192404294,
         0.19407480320948962],
        [0.03009813103709189, 0.17618273001457428, -0.06760958961465136, 0.03047841994033425, -0.009433995621757752,
         0.2599493844493332, 0.1606698395901509])),
}
# fmt: on


def problem(n: int, k: int, seed: int, norm: float) -> State:
    """A random state ``(g, x, p, mu)``."""
    rng = np.random.default_rng(seed)

    def horizontal() -> Matrix:
        x = rng.normal(size=(n, n))
        x = x - x.T
        x[k:, k:] = 0
        return np.asarray(x * (norm * np.sqrt(2) / np.linalg.norm(x)))

    g = np.linalg.qr(rng.normal(size=(n, n)))[0]
    x, p, j = horizontal(), horizontal(), horizontal()
    mu = (x @ p - p @ x) / 2
    mu[k:, k:] *= 2
    return g, x, p, mu - j


def rotate(h: float, state: State, k: int) -> State:
    """The flow of ``<mu, x>``: the integral is a block of the exponential of ``[[x, mu], [0, x]]``."""
    g, x, p, mu = state
    n = len(x)
    block = expm(h * np.block([[x, mu], [np.zeros((n, n)), x]]))
    turn = block[:n, :n]
    impulse = turn.T @ block[:n, n:]
    impulse[k:, k:] = 0
    mu = turn.T @ mu @ turn
    return g @ turn, x, p - impulse, (mu - mu.T) / 2


def integrate(a: list[float], b: list[float], state: State, k: int, steps: int) -> State:
    """``steps`` equal steps over [0, 1]."""
    h = 1.0 / steps
    for _ in range(steps):
        for i in range(len(a)):
            g, x, p, mu = state
            state = rotate(a[i] * h, (g, x + b[i] * h * p, p, mu), k)
        g, x, p, mu = state
        state = g, x + b[-1] * h * p, p, mu
    return state


def distance(first: State, second: State) -> float:
    """Euclidean distance of two states."""
    return float(np.sqrt(sum(np.linalg.norm(x - y) ** 2 for x, y in zip(first, second, strict=True))))


@cache
def times(word: str, letter: str, degree: int) -> tuple[tuple[str, int], ...]:
    """``word * letter`` in words without ``BBA`` up to a degree, as pairs (word, coefficient)."""
    if len(word) >= degree:
        return ()
    if letter == "B" or not word.endswith("BB"):
        return ((word + letter, 1),)
    out: dict[str, int] = {}
    for tail, factor in (("BAB", 2), ("ABB", -1)):
        terms = {word[:-2]: factor}
        for next_letter in tail:
            new: dict[str, int] = {}
            for w, c in terms.items():
                for v, d in times(w, next_letter, degree):
                    new[v] = new.get(v, 0) + c * d
            terms = new
        for w, c in terms.items():
            out[w] = out.get(w, 0) + c
    return tuple((w, c) for w, c in out.items() if c)


def exponential(element: dict[str, float], letters: dict[str, float], degree: int) -> dict[str, float]:
    """``element * exp(letters)``, with letters as a dict of coefficients."""
    total, term = dict(element), dict(element)
    for j in range(1, degree + 1):
        new: dict[str, float] = {}
        for w, c in term.items():
            for letter, factor in letters.items():
                for v, d in times(w, letter, degree):
                    new[v] = new.get(v, 0.0) + c * d * factor / j
        term = new
        for w, c in term.items():
            total[w] = total.get(w, 0.0) + c
    return total


def defect(a: list[float], b: list[float], degree: int) -> float:
    """The largest coefficient, up to a degree, of the composition minus ``exp(A + B)``."""
    product = {"": 1.0}
    for i in range(len(a)):
        product = exponential(product, {"B": b[i]}, degree)
        product = exponential(product, {"A": a[i]}, degree)
    product = exponential(product, {"B": b[-1]}, degree)
    exact = exponential({"": 1.0}, {"A": 1.0, "B": 1.0}, degree)
    return max(abs(product.get(w, 0.0) - exact.get(w, 0.0)) for w in {*product, *exact})


def main() -> None:
    """Print the table."""
    _, a, b = COMPOSITIONS["twelve flows (used)"]
    states = [(problem(*args), args[1]) for args in PROBLEMS]
    exact = [integrate(a, b, state, k, 60) for state, k in states]
    print("order  flows  conditions  next      C        slopes   composition")
    for name, (order, a, b) in COMPOSITIONS.items():
        flows = len(a)
        constants, slopes = [], []
        for (state, k), end in zip(states, exact, strict=True):
            steps = [max(1, round(work / flows)) for work in (LONG if flows >= 15 else WORK[order])]
            errors = [distance(integrate(a, b, state, k, count), end) for count in steps]
            constants.append(errors[1] * (flows * steps[1]) ** order)
            slopes.append(np.log(errors[0] / errors[1]) / np.log(steps[1] / steps[0]))
        mean = np.exp(np.mean(np.log(constants)))
        conditions, following = defect(a, b, order), defect(a, b, order + 1)
        measured = f"{conditions:11.1e} {following:9.1e} {mean:8.1e} {min(slopes):4.1f}-{max(slopes):3.1f}"
        print(f"{order:5} {flows:6} {measured}   {name}")


if __name__ == "__main__":
    main()
