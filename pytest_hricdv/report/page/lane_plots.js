// The plots of a run: its axis of time, its lanes, and a plot for each signal. All show the same window of time.

const RIGHT = 20;
// As high as a signal's curve can be told from a line, and as low as several stay on a screen.
const SIGNAL_HEIGHT = 92;

/** Room for the longest name of a lane or signal, so that the plots stand below each other. */
function roomFor(names) {
  return Math.min(170, 16 + 7.2 * Math.max(8, ...names.map((name) => name.length)));
}

/** The bars and dots within a window of time, bars cut to it. */
function within({ bars, dots }, [begin, end]) {
  const cut = bars.filter((bar) => bar.to >= begin && bar.from <= end).map((bar) => ({ ...bar, from: Math.max(begin, bar.from), to: Math.min(end, bar.to) }));
  return { bars: drawable(cut, [begin, end]), dots: drawable(dots.filter((dot) => dot.time >= begin && dot.time <= end), [begin, end]) };
}

/** The violations within a window of time, as many as can be told apart. */
function violationsWithin(failures, [begin, end]) {
  return drawable(failures.filter((failure) => failure.time >= begin && failure.time <= end), [begin, end]);
}

function axisPlot(width, marginLeft, window) {
  return plotted(plain(width, {
    ariaHidden: "true", marginLeft, marginRight: RIGHT, marginTop: 4, marginBottom: 32, height: 38,
    x: { domain: window, label: "simulated time (s)" }, marks: [Plot.axisX({ anchor: "bottom" })],
  }));
}

/** Actions with as much of their names as fits before the next mark of their lane: [{time, lane, label}]. */
function actionLabels(dots, end, pixels) {
  const acts = dots.filter((dot) => dot.name);
  return acts.map((act) => {
    const next = Math.min(end, ...dots.filter((dot) => dot.lane === act.lane && dot.time > act.time).map((dot) => dot.time));
    return { time: act.time, lane: act.lane, label: fitting(visible(act.name), pixels({ from: act.time, to: next }) - 10) };
  });
}

/** The plot of lanes. `failures`: {lane, name, time} of each violation; with `parts`, of where two runs part; `window`: from when to when. */
function lanePlot(width, room, window, made, names, failures) {
  const shown = new Set(names), { bars, dots } = within({
    bars: made.bars.filter((bar) => shown.has(bar.lane)), dots: made.dots.filter((dot) => shown.has(dot.lane)),
  }, window);
  const pixels = (bar) => ((bar.to - bar.from) / (window[1] - window[0])) * (width - room - RIGHT);
  const marked = violationsWithin(failures, window), wrong = marked.filter((each) => !each.parts), parts = marked.filter((each) => each.parts);
  const tip = { title: (each) => visible(each.tooltip), fill: "var(--card)" };
  return plotted(plain(width, {
    ariaLabel: "Messages, states, switches and monitors over time", marginLeft: room, marginRight: RIGHT, marginTop: 4, marginBottom: 4, height: 8 + 24 * names.length,
    x: { domain: window, axis: null }, y: { domain: names, label: null, tickFormat: visible, tickSize: 0, type: "band", padding: 0.25 },
    marks: [
      Plot.gridX(),
      Plot.ruleX(wrong, { x: "time", stroke: "var(--bad-mark)", strokeDasharray: "3 3" }),
      Plot.ruleX(parts, { x: "time", stroke: "var(--link)", strokeDasharray: "2 3" }),
      Plot.barX(bars, { x1: "from", x2: "to", y: "lane", fill: "fill", stroke: "fill" }),
      Plot.text(bars.filter((bar) => bar.label), { x: (bar) => (bar.from + bar.to) / 2, y: "lane", text: (bar) => fitting(visible(bar.label), pixels(bar)), fill: "var(--ink)" }),
      Plot.dot(dots, { x: "time", y: "lane", symbol: "symbol", fill: "fill", r: 3.5, stroke: "var(--card)", strokeWidth: 0.7 }),
      Plot.text(actionLabels(dots, window[1], pixels), { x: "time", y: "lane", text: "label", textAnchor: "start", dx: 7, fill: "var(--ink)" }),
      Plot.dot(wrong.filter((each) => shown.has(each.name)), { x: "time", y: "name", symbol: "times", stroke: "var(--bad-mark)", r: 6, strokeWidth: 2.5 }),
      Plot.tip(bars, Plot.pointer({ x: (bar) => (bar.from + bar.to) / 2, y: "lane", maxRadius: 30, ...tip })),
      Plot.tip(dots, Plot.pointer({ x: "time", y: "lane", maxRadius: 14, ...tip })),
    ],
    color: { type: "identity" }, symbol: { type: "identity" },
  }));
}

/** The part of a signal within a window, from its value at the begin to its value at the end; gaps are null. */
function pointsWithin(points, [begin, end]) {
  const inside = points.filter(([time]) => time > begin && time < end);
  const last = (time) => points.findLast((point) => point[0] <= time);
  const first = last(begin), ending = last(end);
  return [...(first ? [[begin, first[1]]] : []), ...inside, ...(ending ? [[end, ending[1]]] : [])];
}

/** A signal over time, with the `limits` ({text, value}) that requirements compare it with; `others` are its points in another run. */
function signalPlot(width, marginLeft, window, { name, points }, limits, failures, others = []) {
  const measured = points.filter(([, value]) => value !== null), drawnPoints = pointsWithin(points, window), otherPoints = pointsWithin(others, window);
  const unit = DATA.units[name], label = visible(name) + (unit ? " (" + visible(unit) + ")" : "");
  const values = [...(drawnPoints.some(([, value]) => value !== null) ? drawnPoints : points), ...otherPoints].flatMap(([, value]) => (value === null ? [] : [value])).concat(limits.map((limit) => limit.value));
  const low = Math.min(...values), high = Math.max(...values);
  // The axis of a constant signal needs some height, too.
  const domain = low === high ? [low - 0.5, high + 0.5] : [low, high];
  return plotted(plain(width, {
    ariaLabel: label, marginLeft, marginRight: RIGHT, marginTop: 22, marginBottom: 6, height: SIGNAL_HEIGHT,
    x: { domain: window, axis: null }, y: { label, grid: true, ticks: 3, domain, nice: low !== high },
    marks: [
      Plot.gridX(),
      Plot.ruleX(violationsWithin(failures, window), { x: "time", stroke: "var(--bad-mark)", strokeDasharray: "3 3" }),
      Plot.ruleY(limits, { y: "value", stroke: "var(--bad-mark)", strokeWidth: 1.5, strokeDasharray: "6 3" }),
      Plot.text(limits, { x: window[1], y: "value", text: "text", textAnchor: "end", dy: -6, fill: "var(--bad)" }),
      Plot.line(otherPoints, { x: "0", y: "1", curve: "step-after", stroke: "var(--c2)", strokeWidth: 1.7, strokeDasharray: "5 3" }),
      Plot.line(drawnPoints, { x: "0", y: "1", curve: "step-after", stroke: "var(--c0)", strokeWidth: 1.7 }),
      Plot.tip(measured.filter(([time]) => time >= window[0] && time <= window[1]), Plot.pointerX({ x: "0", y: "1", title: (point) => seconds(point[0]) + ": " + point[1], fill: "var(--card)" })),
    ],
  }));
}

/** What a run's lanes, marks and colours mean. */
function timelineLegend(labelled) {
  const swatches = Object.entries(labelled).map(([lane, labels]) =>
    h("ul", { class: "legend" }, h("li", { class: "soft" }, lane + ":"), labels.map((label, n) => h("li", {}, h("i", { class: "swatch", style: "background:" + fillOf(n) }), label))));
  return [swatches, legend(Object.values(TRIGGERS).map(([outcome, colour]) => ["trigger " + outcome, colour, ""])),
    h("p", { class: "soft small" }, "A requirement's bar begins where it is triggered and ends where it is decided; × and the dashed upright line mark a violation, a dashed level line the limit of a requirement, a dashed green curve the signal in the passing run. A dot is a message, ◆ a disturbance, ■ an action of somebody, a dark bar a switch that is on. A signal keeps its value until it changes; signals are shown with fewer points, their extremes are kept. Of more than " + MOST_MARKS + " marks of a kind as many are drawn.")];
}
