r"""Methods section of a report: the methods applied to its runs, with their equations.

Equations are in the notation of tribopipe.views.html.rendering; those of the paper keep its numbers.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from tribopipe.documents.contact import Contact, Tip
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.recipe import Correction, LawName
from tribopipe.documents.record import Record
from tribopipe.physics.calculation_methods import DistanceConvention
from tribopipe.physics.laws import LAWS, WearLaw, law_label
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.local_wear import LocalWearResult
from tribopipe.results.specific_wear import SpecificWear
from tribopipe.results.study import LawResult, StudyResult
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction

PAPER = (
    "V. Hegadekatte, S. Kurzenhäuser, N. Huber, O. Kraft, “A predictive modeling scheme for wear in tribometers”, "
    "Tribology International."
)
GUM = (
    "JCGM 100:2008, Evaluation of measurement data – Guide to the expression of uncertainty in measurement. "
    "Joint Committee for Guides in Metrology."
)
MONTE_CARLO = (
    "JCGM 101:2008, Evaluation of measurement data – Supplement 1 to the “Guide to the expression of uncertainty in "
    "measurement” – Propagation of distributions using a Monte Carlo method. Joint Committee for Guides in Metrology."
)
PAULE = (
    "R. C. Paule, J. Mandel, “Consensus values and weighting factors”, Journal of Research of the National Bureau of "
    "Standards 87 (1982) 377."
)
AKAIKE = (
    "H. Akaike, “A new look at the statistical model identification”, IEEE Transactions on Automatic Control 19 "
    "(1974) 716."
)
HURVICH = (
    "C. M. Hurvich, C.-L. Tsai, “Regression and time series model selection in small samples”, Biometrika 76 (1989) "
    "297."
)
MATERN = "M. L. Stein, Interpolation of Spatial Data: Some Theory for Kriging, Springer, New York, 1999, section 2.7."
SCHWARZ = "G. Schwarz, “Estimating the dimension of a model”, Annals of Statistics 6 (1978) 461."
G77 = "ASTM G77, Ranking resistance of materials to sliding wear using block-on-ring wear test."
D4172 = "ASTM D4172, Wear preventive characteristics of lubricating fluid (four-ball method)."
ISO_13528 = "ISO 13528, Statistical methods for use in proficiency testing by interlaboratory comparison (E_n number)."


@dataclass(frozen=True)
class Equation:
    """One equation, with its number in the paper if it has one."""

    source: str
    number: str = ""


@dataclass(frozen=True)
class Method:
    """One method in words and equations."""

    title: str
    text: str
    equations: tuple[Equation, ...] = ()
    after: str = ""
    """Text below the equations, which explains the symbols."""
    references: tuple[str, ...] = ()


@dataclass(frozen=True)
class Evidence:
    """Content of a report, which determines its methods."""

    manifests: Sequence[RunManifest]
    results: Sequence[Record]
    """Results of all steps of all runs."""
    study: StudyResult | None = None

    def any(self, kind: type[Record], holds: Callable[[object], object] = lambda _: True) -> bool:
        """Return whether a result of a kind fulfills a condition."""
        return any(isinstance(result, kind) and holds(result) for result in self.results)

    @cached_property
    def wear(self) -> list[WearFit | WearPrediction]:
        """Fits with a k_D, and predictions."""
        return [
            result
            for result in self.results
            if isinstance(result, WearPrediction) or (isinstance(result, WearFit) and result.outcome == "fitted")
        ]

    @property
    def fits(self) -> list[WearFit]:
        """Fits with a k_D."""
        return [result for result in self.wear if isinstance(result, WearFit)]

    @cached_property
    def computed(self) -> list[WearFit | WearPrediction | LawResult]:
        """All results that include computed wear."""
        return [*self.wear, *(() if self.study is None else self.study.laws)]

    @property
    def pins(self) -> list[WearFit | WearPrediction | LawResult]:
        """All results that include computed wear of a pin."""
        return [one for one in self.computed if one.distance_per_rotation is None]

    @property
    def discs(self) -> list[WearFit | WearPrediction | LawResult]:
        """All results that include computed wear of two discs."""
        return [one for one in self.computed if one.distance_per_rotation is not None]

    @property
    def contacts(self) -> list[Contact]:
        """Contacts of the runs, if described."""
        return [one.contact for one in self.manifests if one.contact is not None]

    @cached_property
    def tips(self) -> list[Tip]:
        """Tips of the pins."""
        return [one.pin for one in self.manifests if one.pin is not None]

    @property
    def rounded(self) -> bool:
        """Whether the contact of any pin widens with wear."""
        return any(tip.widens for tip in self.tips)

    @cached_property
    def uniform(self) -> list[Tip]:
        """Tips of the pins if wear was computed under uniform pressure."""
        return self.tips if any(one.engine == "giwm" for one in self.pins) else []

    @cached_property
    def corrections(self) -> set[Correction]:
        """Whether k_D of pins was identified after drift correction or together with it."""
        of_study = {self.study.correction} if self.study is not None else set()
        return {one for one in {fit.correction for fit in self.fits} | of_study if one is not None}


def methods_used(evidence: Evidence) -> list[Method]:
    """Return the methods applied to the runs, in the order of processing."""
    others = [_of_law(law) for name, law in LAWS.items() if name not in _WRITTEN and _wears_by(name)(evidence)]
    return [*(method for used, method in _METHODS if used(evidence)), *others]


def references_of(methods: Iterable[Method]) -> list[str]:
    """Return the references of the methods, each once."""
    return list(dict.fromkeys(reference for method in methods for reference in method.references))


_CLEAN_UP = Method(
    "Signal preprocessing",
    "The signals were preprocessed in named steps; each step is listed with the changes it made. The recorded signals "
    "are kept "
    "unchanged.",
)
_DRIFT = Method(
    "Drift of the depth sensor",
    "The sensor reading is the sum of the wear of both bodies, an offset, and a drift that is assumed to be linear in "
    "time. The "
    "corrected wear ends at the post-test measurement:",
    (
        Equation(r"w ( t ) = g ( d ( t ) − z ) − ρ ( t − t_0 )"),
        Equation(r"ρ = \frac{g ( d ( t_{\text{end}} ) − z ) − h_{\text{end}}}{t_{\text{end}} − t_0}"),
    ),
    "d is the depth signal, g the scale of the sensor, z its zero offset at the start of sliding, ρ the drift rate, "
    "and "
    "h_end the wear measured after the test. Zero offset and final value are fitted to the first and the last part "
    "of the signal.",
    (PAPER,),
)
_DRIFT_BY_MODEL = Method(
    "Model of the depth signal",
    "Wear and all other contributions to the depth signal were fitted together, with the post-test measurement. The "
    "corrected wear is the depth signal minus the mean of all contributions other than wear:",
    (
        Equation(r"g y ( t ) = z + r t + h ( s ; k_D ) + h_d + a ( 1 − e^{− t / τ} ) + f ( t ) + e ( t )"),
        Equation(r"h_{\text{end}} = h ( s_{\text{end}} ; k_D ) ± u ( h_{\text{end}} )"),
    ),
    "y is the depth signal, g the scale of the sensor, z the zero offset, r the drift rate, h the wear of the pin, "
    "h_d that of the disc, and h_end the measured wear of the pin. Settling with the amplitude a and the time "
    "constant τ, and a shift with the recorded temperature, are alternative contributions, weighted by their model "
    "evidence. f "
    "represents low-frequency fluctuations as a stationary Matérn process whose amplitude and correlation length are "
    "marginalized; e is the noise of block averages.",
    references=(MATERN,),
)
_FRICTION = Method(
    "Friction",
    "The friction coefficient was fitted by bounded least squares over the sliding distance, excluding the loading "
    "ramp:",
    (Equation(r"μ ( s ) = A e^{− s / c} + b", "7"),),
    "The standard uncertainties of A, b and c take the autocorrelation of the residuals into account. If μ is "
    "calculated from force and load, the uncertainties of A and b include that of the load. The uncertainty of c "
    "includes that of the speed or radius used to calculate the distance.",
    (PAPER,),
)
_STEADY = Method(
    "Steady-state friction",
    "If the data do not distinguish an exponential from a constant or a straight line, only the steady-state value is "
    "reported. The criterion is the Bayesian information criterion with the number of independent samples.",
    references=(SCHWARZ,),
)
_SPECIFIC = Method(
    "Specific wear rate",
    "For each body whose wear volume is known,",
    (Equation(r"k = \frac{V}{F_N s}"),),
    "where V is the volume from the measurement with the smallest uncertainty, F_N the mean normal load and s the "
    "sliding distance.",
)
_ARCHARD = Method(
    "Archard's wear law",
    "The wear volume is proportional to load and sliding distance; the surface recedes in proportion to the local "
    "pressure p:",
    (
        Equation(r"\frac{V}{s} = k \frac{F_N}{H}", "1"),
        Equation(r"\frac{d h}{d s} = k_D p"),
    ),
    "k_D = k/H is the dimensional wear coefficient; 1 mm³/(N·mm) is 1 mm²/N.",
    (PAPER,),
)
_SARKAR = Method(
    "Sarkar's wear law",
    "Friction increases wear through junction growth:",
    (
        Equation(r"\frac{V}{s} = k \frac{F_N}{H} \sqrt{1 + 3 μ^2}", "2"),
        Equation(r"\frac{d h}{d s} = k_D p \sqrt{1 + 3 μ^2}"),
    ),
    "with μ(s) as fitted or as measured, as stated in the options.",
    (PAPER,),
)
_PIN = Method(
    "Global Incremental Wear Model for a pin",
    "The pressure is uniform over the contact of radius a, which widens with wear and elastic displacement:",
    (
        Equation(r"\frac{1}{E_c} = \frac{1 − ν_p^2}{E_p} + \frac{1 − ν_d^2}{E_d}", "3"),
        Equation(r"a_0^3 = \frac{3 F_N R_P}{4 E_c}", "4"),
        Equation(r"h^e = \frac{F_N}{2 E_c a}", "5"),
        Equation(r"h_{i + 1} = k_D p_i Δ s_i + h_i , \quad p = \frac{F_N}{π a^2}", "6"),
    ),
    "Eq. 4 is the contact radius before wear, Eq. 5 the elastic displacement, Eq. 6 one step of sliding.",
    (PAPER,),
)
_SPHERE = Method(
    "Exact curve for a sphere",
    "In the limit of small steps, the depth h depends only on the worn volume v. Fits and predictions use this curve, "
    "in closed form, instead of steps:",
    (
        Equation(r"v = k_D F_N S , \quad S = ∫_0^s f d s"),
        Equation(r"R − \sqrt{R^2 − a^2} = h + \frac{F_N}{2 E_c a}"),
        Equation(
            r"v = V_{\text{cap}} ( a ) − V_{\text{cap}} ( a_* ) + \frac{π F_N}{2 E_c} ( a − a_* ) , \quad "
            r"V_{\text{cap}} = \frac{π c^2}{3} ( 3 R − c )"
        ),
    ),
    "f is the factor of the wear law, 1 for Archard's law; c = R − √(R² − a²) is the height of a spherical cap with "
    "the base radius a, and a* is the radius of the unworn contact.",
)
_TRUNCATED = Method(
    "Sphere truncated before the test",
    "The wear depth follows the curve of a full sphere, h_s(v), starting at the height of the missing cap:",
    (Equation(r"h ( v ) = h_s ( v_0 + v ) − h_s ( v_0 )"),),
)
_FLAT = Method(
    "Flat pin",
    "The contact radius a is constant, so that the wear depth is the wear volume divided by the contact area:",
    (Equation(r"h = \frac{v}{π a^2} , \quad v = k_D F_N S , \quad S = ∫_0^s f d s"),),
    "f is the factor of the wear law, 1 for Archard's law.",
)
_BY_VOLUME = Method(
    "Wear volume of a pin if the disc also wears",
    "If the disc has worn as well, the wear volume of the pin follows from its shape, without elastic displacement. "
    "The scar widens with the depth of the groove, h_d, relative to the wear depth of the pin, h_p:",
    (
        Equation(r"v = k_D F_N S = g ( h_d / h_p ) V_{\text{cap}} ( h_p ) , \quad S = ∫_0^s f d s"),
        Equation(r"g ( q ) = \frac{16}{π} ∫_0^1 t^2 \sqrt{1 − t^2 + q ( 1 − t^3 )} d t"),
    ),
    "f is the factor of the wear law, 1 for Archard's law.",
)
_BLOCK = Method(
    "Wear volume of a block on a ring",
    "The block, of width B, wears to a cylindrical segment of the radius r of the ring. With a scar of width b along "
    "the sliding direction,",
    (Equation(r"V = B \left( r^2 \arcsin \frac{b}{2 r} − \frac{b}{4} \sqrt{4 r^2 − b^2} \right) = k_D F_N S"),),
    "S = ∫ f ds is the effective sliding distance; f is the factor of the wear law, 1 for Archard's law.",
    (G77,),
)
_FOUR_BALLS = Method(
    "Contacts in a four-ball test",
    "The centers of the balls, of radius R, are the vertices of a regular tetrahedron. Under a load F along the axis, "
    "each contact carries F_n at the distance R_t from the axis, and corresponds to a ball of radius R/2 on a flat:",
    (
        Equation(r"F_n = \frac{F}{\sqrt{6}} , \quad R_t = \frac{R}{\sqrt{3}}"),
        Equation(r"μ = \frac{\sqrt{2} T}{R F}"),
    ),
    "T is the friction torque.",
    (D4172,),
)
_BOTH_WEAR = Method(
    "Wear of a pin and its wear track",
    "Archard's law holds at each point of both bodies, which remain in contact. In each slice along the sliding "
    "direction, the depth of the groove is proportional to the cross-sectional area A that the pin has lost there; L "
    "is the sliding distance between successive passes of the pin. The sizes of scar and groove are determined by the "
    "wear volumes of both bodies:",
    (
        Equation(r"h_d ( x ) = \frac{k_2}{k_1 L} A ( x )"),
        Equation(r"V_i = k_i F_N S"),
    ),
)
_LOST = Method(
    "Identification of k_D from the wear volume",
    "If only the final wear volume of a body was measured, its k_D is the mean over the test, for any geometry:",
    (Equation(r"k_{D , i} = \frac{V_i}{F_N S}"),),
    "S = ∫ f ds is the effective sliding distance; f is the factor of the wear law, 1 for Archard's law.",
)
_LOCAL = Method(
    "Wear with the local contact pressure",
    "Where stated, wear was simulated with the local contact pressure instead of a uniform one. Each point recedes "
    "according to the wear law and the pressure at that point:",
    (Equation(r"\frac{∂ h ( x , s )}{∂ s} = k_D p ( x , s )"),),
)
_DISCS = Method(
    "Global Incremental Wear Model for two discs",
    "The contact area of the discs is flat, with half-width a_x across and half-length a_z along the rolling "
    "direction:",
    (
        Equation(r"u = \frac{F_N}{2 E_c \sqrt{a_x a_z}}", "10"),
        Equation(r"a_z^2 = κ^2 \frac{4 F_{N l} r_{\text{eq}}}{π E_c}", "12, 15"),
        Equation(r"p^2 = \frac{π^2}{16} \frac{F_{N l} E_c}{π r_{\text{eq}}}", "13, 16"),
        Equation(r"r_{1 x} − \sqrt{r_{1 x}^2 − a_x^2} = h_1 + h_2 + u"),
        Equation(
            r"F_{N l} = \frac{F_N}{2 a_x} , \quad "
            r"\frac{1}{r_{\text{eq}}} = \frac{1}{r_1 − h_1} + \frac{1}{r_2 − h_2}"
        ),
    ),
    "κ is π/4 as published, and 1 for the line-load convention. The number of rotations N is an integral over the "
    "worn height, in the limit of small steps; in the paper, each step is one rotation.",
    (PAPER,),
)
_CONVENTIONS: dict[DistanceConvention, Method] = {
    "full-slip": Method(
        "Sliding distance per rotation: full slip",
        "Every point is assumed to slide the full slip distance s in each rotation:",
        (
            Equation(r"\frac{d h_1}{d N} = k_1 p s", "14 a"),
            Equation(r"\frac{d h_2}{d N} = k_2 p s \frac{n_2}{n_1}", "14 b"),
        ),
        "This k_D can be compared only with values based on the same convention, not with the k_D of a pin.",
        (PAPER,),
    ),
    "contact-width": Method(
        "Sliding distance per rotation: contact width",
        "A point is assumed to slide over the length of the contact in each rotation, regardless of the slip:",
        (Equation(r"\frac{d h}{d N} = 2 k_D p a_z", "11"),),
        references=(PAPER,),
    ),
    "line-load": Method(
        "Sliding distance per rotation: line load",
        "A point is assumed to slide over the length of the contact in each rotation, with κ = 1, so that the "
        "pressure carries the whole load:",
        (Equation(r"\frac{d h}{d N} = k_D F_{N l}"),),
    ),
    "volume-conserving": Method(
        "Sliding distance per rotation: volume conserving",
        "A point is assumed to slide only while it is in contact, so that each disc loses V = k_D·F_N·s:",
        (Equation(r"\frac{d h}{d N} = k_D F_{N l} \frac{s}{2 π ( r − h )}"),),
    ),
}
_TWO_STEPS = Method(
    "Identification of k_D",
    "k_D is obtained by a least-squares fit of the wear law to the drift-corrected wear.",
)
_MODEL = Method(
    "Identification of k_D together with drift",
    "The final wear depth H was estimated from the depth signal and the post-test measurement, using a single model "
    "for wear and drift in which the wear depth is h(s; k_D) according to the wear law. The corresponding k_D is:",
    (Equation(r"k_D = \frac{V ( H )}{F_N S}"),),
    "V is the worn volume at the depth H, and S = ∫ f ds the effective sliding distance; f is the factor of the wear "
    "law, 1 for Archard's law. If depth signal and measurement differ by more than three standard uncertainties of "
    "their difference, the depth signal is not used, and k_D is determined from the measurement alone. Without a "
    "post-test measurement, k_D is determined from the depth signal alone.",
)
_BOTH_DISCS = Method(
    "Identification of both k_D values",
    "The coefficients of both discs were fitted together by weighted least squares to all measurements of the discs, "
    "taken at the end of the test and at interruptions.",
)
_BUDGET = Method(
    "Uncertainty budget",
    "The standard uncertainty of k_D combines those of the inputs by first-order propagation. The budget lists each "
    "contribution with its sign.",
    (Equation(r"u^2 ( k_D ) = Σ_i c_i^2 u^2 ( x_i ) , \quad c_i = \frac{∂ k_D}{∂ x_i}"),),
    references=(GUM,),
)
_DRAWN = Method(
    "Coverage intervals",
    "Intervals contain 95 % of the Monte Carlo draws. Systematic inputs, such as load, tip radius, moduli, sensor "
    "scale and post-test measurements, are drawn once per run. The noise of the depth signal is drawn with its "
    "autocorrelation.",
    references=(MONTE_CARLO,),
)
_VERDICTS = Method(
    "Agreement with the model",
    "The agreement of a run with the model is assessed with the E_n number. It is δ, the measured minus the predicted "
    "wear, divided by U, the half-width of the 95 % interval for δ on the side toward zero:",
    (Equation(r"E_n = \frac{δ}{U}"),),
    "For |E_n| ≤ 1, measured and predicted wear agree. The interval is calculated by Monte Carlo, so that errors "
    "common to both cancel. The model is rated as over- or under-predicting only if δ exceeds its 99 % limits. Between "
    "the 95 % and the 99 % limits, the comparison is inconclusive. It is also inconclusive if neither the final wear "
    "nor the wear curve would reveal an error in k_D of a factor of two. Measurements along the curve are compared "
    "with a simultaneous band that contains 95 % of the curves as a whole.",
    (ISO_13528, MONTE_CARLO),
)
_SEVERAL = Method(
    "Common k_D of several runs",
    "Runs from which a common k_D is identified are weighted according to their individual standard uncertainty u and "
    "the between-run standard deviation τ, which is estimated from the scatter between runs; both refer to √k_D:",
    (Equation(r"w_i = \frac{1}{u_i^2 + τ^2}"),),
    references=(PAULE,),
)
_COMPARED = Method(
    "Comparison of the wear laws",
    "The laws are compared by Akaike's criterion for their fits to each curve, corrected for the number n of averages. "
    "The p free parameters are k_D, zero offset, drift, the variance and those of the law. A difference below 2 is "
    "inconclusive.",
    (Equation(r"\text{AIC} = n \text{ ln } \frac{χ^2}{n} + 2 p + \frac{2 p ( p + 1 )}{n − p − 1}"),),
    references=(AKAIKE, HURVICH),
)


def _between_runs(evidence: Evidence) -> bool:
    study = evidence.study
    return study is not None and any(body.between_runs for law in study.laws for body in law.bodies.values())


def _of_law(law: WearLaw) -> Method:
    """Return the method for a law from what it states of itself."""
    meant = "; ".join(f"{name.replace('_', ' ')}: {known.meaning}" for name, known in law.parameters().items())
    words = " ".join(filter(None, [f"dh/ds = {law.rate}.", meant]))
    return Method(f"Wear law: {law_label(law.name)}", words, references=(law.citation,))


def _wears_by(law: LawName) -> Callable[[Evidence], object]:
    return lambda told: any(one.model == law for one in told.computed)


def _counted(convention: DistanceConvention) -> Callable[[Evidence], object]:
    return lambda told: any(one.distance_per_rotation == convention for one in told.discs)


def _drift_was_corrected(correction: Correction) -> Callable[[Evidence], object]:
    return lambda told: told.any(
        DriftCorrection,
        lambda one: isinstance(one, DriftCorrection) and (one.outcome, one.correction) == ("corrected", correction),
    )


def _is_local(told: Evidence) -> bool:
    compared = () if told.study is None else told.study.laws
    return (
        told.any(LocalWearResult)
        or any(one.engine == "local" for one in told.pins)
        or any(body.engines for law in compared for run in law.runs for body in run.bodies.values())
    )


def _has_budget(told: Evidence) -> bool:
    return any(body.budget for fit in told.fits for body in fit.bodies.values())


def _has_draws(told: Evidence) -> bool:
    return told.study is not None or any(body.monte_carlo for fit in told.fits for body in fit.bodies.values())


def _by_lost_volume(told: Evidence) -> bool:
    fits = [one for one in told.pins if isinstance(one, WearFit)]
    return any(body.fitted_end_depth is None for fit in fits for body in fit.bodies.values())


_WRITTEN = ("archard", "sarkar")
"""Laws whose methods are described here."""
_METHODS: tuple[tuple[Callable[[Evidence], object], Method], ...] = (
    (lambda told: told.any(CleanUp, lambda one: getattr(one, "changes", ())), _CLEAN_UP),
    (_drift_was_corrected("two-step"), _DRIFT),
    (_drift_was_corrected("model"), _DRIFT_BY_MODEL),
    (lambda told: told.any(FrictionFit, lambda one: getattr(one, "outcome", "") == "exponential"), _FRICTION),
    (lambda told: told.any(FrictionFit, lambda one: getattr(one, "outcome", "") == "steady-only"), _STEADY),
    (lambda told: told.any(SpecificWear, lambda one: getattr(one, "outcome", "") == "evaluated"), _SPECIFIC),
    (_wears_by("archard"), _ARCHARD),
    (_wears_by("sarkar"), _SARKAR),
    (lambda told: any(one.engine == "giwm" for one in told.pins), _PIN),
    (lambda told: any(tip.widens for tip in told.uniform), _SPHERE),
    (lambda told: any(tip.flat for tip in told.uniform), _TRUNCATED),
    (lambda told: any(tip.constant_area for tip in told.uniform), _FLAT),
    (lambda told: any(one.contacts_per_turn > 1 for one in told.contacts), _FOUR_BALLS),
    (lambda told: any(one.engine == "volume" for one in told.pins) and told.rounded, _BY_VOLUME),
    (lambda told: any(tip.line for tip in told.tips), _BLOCK),
    (lambda told: any(len(one.bodies) > 1 for one in told.pins), _BOTH_WEAR),
    (_is_local, _LOCAL),
    (lambda told: told.discs, _DISCS),
    *((_counted(convention), method) for convention, method in _CONVENTIONS.items()),
    (lambda told: "two-step" in told.corrections, _TWO_STEPS),
    (lambda told: "model" in told.corrections, _MODEL),
    (_by_lost_volume, _LOST),
    (lambda told: told.discs, _BOTH_DISCS),
    (_has_budget, _BUDGET),
    (_has_draws, _DRAWN),
    (lambda told: told.study, _VERDICTS),
    (_between_runs, _SEVERAL),
    (lambda told: told.study is not None and told.study.comparisons, _COMPARED),
)
