// Coverage over tests and time: suites compared, and the smallest suite.

const suiteSeries = (points, note) =>
  DATA.curves.map((curve, n) => ({ name: DATA.suites[n], n, points: points(curve, n), note: note && note(curve, n) }));

const SUITE_PLOTS = {
  coverage: (place) => {
    const series = suiteSeries((curve, n) => {
      const values = TESTS.filter((test) => test.suite === n && test.percent !== null).map((test) => test.percent);
      return values.sort((a, b) => a - b).map((value, rank) => [rank + 1, value]);
    });
    linePlot(place, series, { label: "tests, in ascending order of coverage", tickFormat: wholeTick },
      { label: "statements covered (%)", domain: percentDomain(series) }, "Statement coverage of each test");
  },
  closure: (place) => {
    const kind = place.dataset.kind, series = suiteSeries((curve) => curve.closure[kind] || []);
    linePlot(place, series, { label: "tests run", tickFormat: wholeTick },
      { label: kind + " covered (%)", domain: percentDomain(series) }, "Closure of " + kind);
  },
  learning: (place) => {
    const series = suiteSeries((curve) => curve.learning);
    linePlot(place, series, { label: "iteration", tickFormat: wholeTick },
      { label: "largest change of Q", type: "log", tickFormat: (value) => (value < 0.001 ? value.toExponential(0) : String(value)), ticks: 5 }, "Convergence of Q");
  },
};

function suitesPage(section) {
  const places = [...section.querySelectorAll("[data-plot]")];
  for (const place of places) SUITE_PLOTS[place.dataset.plot](place);
  if (places.length) section.querySelector("[data-unplotted]").hidden = places.some((place) => !place.hidden);
}

/** The points that each test of the smallest suite adds. */
/** Shows what is not covered of one kind only; the group of all others opens, as what is chosen may be in it. */
function chooseKind(view) {
  const bar = view.querySelector(".kinds");
  if (!bar) return;
  const choice = bar.querySelector("select");
  bar.hidden = false;
  choice.addEventListener("change", () => {
    for (const hole of view.querySelectorAll(".hole")) hole.hidden = choice.value !== "" && hole.dataset.group !== choice.value;
    for (const others of view.querySelectorAll("details:has(.hole):not(.hole)")) {
      others.open = choice.value !== "";
      others.hidden = !others.querySelector(".hole:not([hidden])");
    }
  });
}

function closurePage(view) {
  chooseKind(view);
  const place = view.querySelector("[data-plot=gain]"), minimal = DATA.minimal;
  if (!place) return; // no test, no suite
  linePlot(place, [
    { name: "smallest suite", n: 0, points: minimal.curve, note: Object.keys(minimal.gains).length + " tests", curve: "step-after" },
    { name: "all tests, as listed", n: 1, points: minimal.growth, note: TESTS.length + " tests", curve: "step-after" },
  ], { label: "simulated time (s)" }, { label: "points covered", zero: true }, "Points covered over simulated time");
}
