// A requirement's plots: when it was triggered, and the margin of each test.

const MARKS = { P: ["passed", "circle", "var(--ok-mark)"], F: ["failed", "times", "var(--bad-mark)"], K: ["failed as is known", "times", "var(--warn)"] };

function triggersPlot(place, n) {
  const triggers = DATA.triggers[n];
  if (!triggers) {
    place.append(h("p", { class: "soft" }, "No test triggered it, or the report has no timelines."));
    return;
  }
  const bars = [], width_s = triggers.width_s;
  Object.entries(triggers.suites).forEach(([suite, counts]) => counts.forEach((count, bin) => {
    if (count) bars.push({ suite: DATA.suites.indexOf(suite), from: bin * width_s, to: (bin + 1) * width_s, count });
  }));
  const tooltip = (bar) => visible(DATA.suites[bar.suite]) + ": " + bar.count + " from " + bar.from + " to " + bar.to + " s";
  drawn(place, (width) => plotted(plain(width, {
    ariaLabel: "Triggers over time", x: { label: "simulated time (s)" }, y: { label: "triggers, all tests", grid: true, tickFormat: wholeTick },
    marks: [
      Plot.rectY(bars, Plot.stackY({ x1: "from", x2: "to", y: "count", order: "suite", fill: (bar) => colourOf(bar.suite), title: tooltip, tip: { fill: "var(--card)" } })),
      Plot.ruleY([0]),
    ],
  })));
  const suites = [...new Set(bars.map((bar) => bar.suite))].sort((a, b) => a - b);
  place.append(legend(suites.map((suite) => [DATA.suites[suite], colourOf(suite), ""])));
  place.append(tabled("Triggers over time", ["Suite", "From (s)", "To (s)", "Triggers"],
    () => bars.map((bar) => [DATA.suites[bar.suite], bar.from, bar.to, bar.count])));
}

function marginsPlot(place, n) {
  const dots = TESTS.filter((test) => test.margins[n] !== null && test.verdicts[n] in MARKS).map((test) => ({
    test, margin: test.margins[n], letter: test.verdicts[n],
    // Spread over the height of the suite's strip by the golden ratio: even and deterministic.
    y: test.suite + 0.7 * ((test.number * 0.618034) % 1 - 0.5),
  }));
  if (!dots.length) {
    place.append(h("p", { class: "soft" }, "No test has a margin: nothing was compared."));
    return;
  }
  const unit = DATA.marginUnits[n], suites = [...new Set(dots.map((dot) => dot.test.suite))].sort((a, b) => a - b);
  const room = 18 + 7.2 * Math.max(...suites.map((suite) => DATA.suites[suite].length));
  const low = suites[0] - 0.5, high = suites[suites.length - 1] + 0.5;
  drawn(place, (width) => plotted(plain(width, {
    ariaLabel: "Margins of all tests", height: 90 + 90 * suites.length, marginLeft: Math.min(room, width / 3), marginRight: 30,
    x: { label: "margin" + (unit ? " (" + unit + ")" : ""), grid: true, nice: true, ticks: Math.max(2, Math.floor(width / 120)) },
    y: { domain: [high, low], ticks: suites, tickFormat: (suite) => visible(DATA.suites[suite] || ""), label: null, tickSize: 0 },
    marks: [
      Plot.ruleX([0], { strokeDasharray: "3 3" }),
      Object.entries(MARKS).map(([letter, [, symbol, colour]]) => Plot.dot(dots.filter((dot) => dot.letter === letter), {
        x: "margin", y: "y", symbol, stroke: colour, r: 3.5, strokeWidth: 1.5, href: (dot) => "#test/" + dot.test.anchor, ariaLabel: (dot) => visible(dot.test.id) + ": margin " + dot.margin,
        pointerEvents: "all", // the inside of a circle, too
      })),
      Plot.tip(dots, Plot.pointer({ x: "margin", y: "y", title: (dot) => visible(dot.test.id) + "\nmargin " + dot.margin + (unit ? " " + unit : ""), fill: "var(--card)" })),
    ],
  })));
  place.append(h("p", { class: "legend small" }, "○ passed, × failed" + (dots.some((dot) => dot.letter === "K") ? " (in another colour: where that is known)" : "")));
  place.append(tabled("Margins of all tests", ["Test", "Verdict", "Margin" + (unit ? " (" + unit + ")" : "")],
    () => [...dots].sort((a, b) => a.margin - b.margin).map((dot) => [testLink(dot.test), MARKS[dot.letter][0], dot.margin])));
}

function requirementPage(section) {
  const n = Number(section.dataset.number);
  triggersPlot(section.querySelector("[data-plot=triggers]"), n);
  marginsPlot(section.querySelector("[data-plot=margins]"), n);
}
