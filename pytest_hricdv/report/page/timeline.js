// A run's timeline: the robot's state, messages, signals, and triggers of requirements, over simulated time.

const TRIGGERS = { "": ["passed", "var(--ok-mark)"], "!": ["failed", "var(--bad-mark)"], "?": ["pending at the end", "var(--nc-mark)"] };

// Marks of a lane. There are fewer columns of pixels to tell them apart by, and a browser is busy for minutes with a
// million of them.
const MOST_MARKS = 2000;

/** The marks to draw: of a lane with too many, the first in each of as many spans of time, one that failed before others. */
function drawable(marks, end) {
  const counts = {}, kept = new Map();
  for (const { lane } of marks) counts[lane] = (counts[lane] || 0) + 1;
  marks.forEach((mark, n) => {
    const span = Math.floor(((mark.time ?? mark.from) / end) * MOST_MARKS);
    const place = counts[mark.lane] > MOST_MARKS ? mark.lane + "\t" + span : n;
    const first = kept.get(place);
    if (!first) kept.set(place, { mark, more: 0 });
    else {
      first.more += 1;
      if (mark.failed && !first.mark.failed) first.mark = mark;
    }
  });
  return [...kept.values()].map(({ mark, more }) => (more ? { ...mark, tooltip: mark.tooltip + "\nand " + more + " more at about this time" } : mark));
}

function parsedMessages(timeline) {
  return timeline.messages.map((text) => {
    const [time, sender, topic, json] = text.split("\t");
    let fields = {};
    try { fields = JSON.parse(json); } catch { fields = { "": json }; }
    return { time: Number(time), sender, topic, fields };
  });
}

function parsedSignal(text, end) {
  const numbers = text.split(" ").map(Number), points = [];
  for (let n = 0; n + 1 < numbers.length; n += 2) points.push([numbers[n], numbers[n + 1]]);
  if (points.length) points.push([end, points[points.length - 1][1]]);
  return points;
}

function parsedTriggers(text) {
  return text.split(" ").map((each) => {
    const mark = /[!?]$/.test(each) ? each.slice(-1) : "";
    const [begin, end] = each.replace(/[!?]$/, "").split("-").map(Number);
    return { begin, end, mark };
  });
}

/** The points of a signal with a gap (null) wherever its switch, if it has one, is off. */
function withGaps(points, name, timeline) {
  const switched = timeline.signals[DATA.sampledWhile[name]];
  if (!switched) return points;
  const off = (time, value) => [time, value ? undefined : null];
  const merged = [...points.map(([time, value]) => [time, value]), ...parsedSignal(switched, timeline.end_s).slice(0, -1).map(([time, on]) => off(time, on))];
  merged.sort((a, b) => a[0] - b[0]);
  let on = false, last = null;
  return merged.flatMap(([time, value]) => {
    const ends = on && value === null;
    if (value === null) on = false;
    else if (value === undefined) on = true;
    else last = value;
    return ends ? [[time, last], [time, null]] : [[time, on ? last : null]];
  });
}

const isSwitch = (name, points) => !(name in DATA.units) && points.every(([, value]) => value === 0 || value === 1);

/** Spans [from, to, label] over which the robot was in a state. */
function stateSpans(messages, end) {
  const [topic, field] = DATA.state.split(".");
  const entered = messages.filter((each) => each.topic === topic && field in each.fields);
  return entered.map((each, n) => ({
    from: each.time, to: n + 1 < entered.length ? entered[n + 1].time : end, label: String(each.fields[field]),
  })).filter((span) => span.to > span.from);
}

/** Spans [from, to, label] of a signal that is a text. */
function textSpans(changes, end) {
  return changes.map(([from, label], n) => ({ from, to: n + 1 < changes.length ? changes[n + 1][0] : end, label }))
    .filter((span) => span.to > span.from);
}

/** The colour of a lane's n-th label: when the colours are used up, stronger ones follow. */
function fillOf(n) {
  return "color-mix(in srgb, " + colourOf(n) + " " + (28 + 24 * (Math.floor(n / COLOURS.length) % 3)) + "%, var(--card))";
}

/** As much of a label as fits into so many pixels; nothing where that would say nothing. */
function fitting(label, pixels) {
  const most = Math.floor(pixels / 7);
  return label.length <= most ? label : most < 3 ? "" : label.slice(0, most - 1) + "…";
}

/** Who acts in an abstract test, where its lines say so: "nurse: press call". */
function actorsOf(abstract) {
  return [...new Set(abstract.map((line) => (/^(\w+): /.exec(line) ?? [])[1]).filter(Boolean))];
}

/** The lane of a line: that of its actor; of several actors, what is none of theirs is the test's. */
function laneOf(line, abstract) {
  return (/^(\w+): /.exec(line) ?? [])[1] ?? (actorsOf(abstract).length ? "the test" : "the human");
}

/** Bars and dots with their lanes and tooltips, the names of the lanes from top to bottom, and the labels of lanes. */
function lanes({ timeline, acted, abstract, seen = [] }) {
  const messages = parsedMessages(timeline), end = timeline.end_s, bars = [], dots = [], names = [], labelled = {};
  const states = DATA.state ? stateSpans(messages, end) : [];
  const stateTopic = states.length ? DATA.state.split(".")[0] : null;
  const addSpans = (lane, spans) => {
    const labels = [...new Set(spans.map((span) => span.label))];
    if (!spans.length) return;
    names.push(lane);
    labelled[lane] = labels;
    for (const span of spans) {
      bars.push({ lane, ...span, fill: fillOf(labels.indexOf(span.label)), tooltip: span.label + "\n" + seconds(span.from) + " to " + seconds(span.to) });
    }
  };
  addSpans("state", states);
  if (acted.length) names.push(...(actorsOf(abstract).length ? actorsOf(abstract) : ["the human"]));
  if (names.length && abstract.some((line, n) => typeof acted[n] === "number" && !names.includes(laneOf(line, abstract)))) names.push("the test");
  names.push(...actorsOf(seen.map(([, act]) => act)));
  for (const [time, act] of seen) {
    dots.push({ lane: laneOf(act, [act]), time, symbol: "square", fill: "var(--c3)", tooltip: seconds(time) + ": " + act });
  }
  acted.forEach((time, n) => typeof time === "number" && dots.push({
    lane: laneOf(abstract[n], abstract), time, symbol: "square", fill: "var(--c2)", tooltip: seconds(time) + ": " + (n + 1) + " " + abstract[n],
  }));
  for (const each of messages.filter((message) => message.topic !== stateTopic)) {
    if (!names.includes(each.topic)) names.push(each.topic);
    const fields = Object.entries(each.fields).map(([name, value]) => name + " " + value).join(", ");
    dots.push({ lane: each.topic, time: each.time, symbol: "circle", fill: "var(--c0)", tooltip: seconds(each.time) + ": " + each.sender + (each.topic.includes(" ") ? ": " : " sends ") + each.topic + "\n" + fields });
  }
  for (const [name, changes] of Object.entries(timeline.texts ?? {})) addSpans(name, textSpans(changes, end));
  for (const [name, text] of Object.entries(timeline.signals)) {
    const points = parsedSignal(text, end);
    if (!isSwitch(name, points)) continue;
    names.push(name);
    points.slice(0, -1).forEach(([from, value], n) => {
      if (value) bars.push({ lane: name, from, to: points[n + 1][0], fill: "var(--c5)", tooltip: name + " from " + seconds(from) + " to " + seconds(points[n + 1][0]) });
    });
  }
  for (const [name, text] of Object.entries(timeline.triggers).sort(([a], [b]) => natural(a, b))) {
    names.push(name);
    for (const { begin, end: over, mark } of parsedTriggers(text)) {
      const [outcome, colour] = TRIGGERS[mark];
      const tooltip = name + " triggered at " + seconds(begin) + "\n" + outcome + " at " + seconds(over);
      const failed = mark === "!";
      bars.push({ lane: name, from: begin, to: over, fill: colour, tooltip, failed });
      dots.push({ lane: name, time: begin, symbol: failed ? "triangle" : "circle", fill: colour, tooltip, failed });
    }
  }
  return { names, bars: drawable(bars, end), dots: drawable(dots, end), labelled };
}

/** Room for the longest name of a lane or signal, so that the plots stand below each other. */
function roomFor(names) {
  return Math.min(170, 16 + 7.2 * Math.max(8, ...names.map((name) => name.length)));
}

/** The plot of all lanes. `failures`: {name, time} of each violation. */
function lanePlot(width, timeline, { names, bars, dots }, failures) {
  const pixels = (bar) => ((bar.to - bar.from) / timeline.end_s) * (width - roomFor(names) - 20);
  const wrong = failures.filter((each) => names.includes(each.name));
  const tip = { title: (each) => visible(each.tooltip), fill: "var(--card)" };
  return Plot.plot(plain(width, {
    ariaLabel: "Messages, states, switches and monitors over time", marginLeft: roomFor(names), marginTop: 8, height: 48 + 24 * names.length,
    x: { domain: [0, timeline.end_s], label: "simulated time (s)", grid: true },
    y: { domain: names, label: null, tickFormat: visible, tickSize: 0, type: "band", padding: 0.25 },
    marks: [
      Plot.ruleX(wrong, { x: "time", stroke: "var(--bad-mark)", strokeDasharray: "3 3" }),
      Plot.barX(bars, { x1: "from", x2: "to", y: "lane", fill: "fill", stroke: "fill" }),
      Plot.text(bars.filter((bar) => bar.label), { x: (bar) => (bar.from + bar.to) / 2, y: "lane", text: (bar) => fitting(visible(bar.label), pixels(bar)), fill: "var(--ink)" }),
      Plot.dot(dots, { x: "time", y: "lane", symbol: "symbol", fill: "fill", r: 3.5, stroke: "var(--card)", strokeWidth: 0.7 }),
      Plot.dot(wrong, { x: "time", y: "name", symbol: "times", stroke: "var(--bad-mark)", r: 6, strokeWidth: 2.5 }),
      Plot.tip(bars, Plot.pointer({ x: (bar) => (bar.from + bar.to) / 2, y: "lane", maxRadius: 30, ...tip })),
      Plot.tip(dots, Plot.pointer({ x: "time", y: "lane", maxRadius: 14, ...tip })),
    ],
    color: { type: "identity" }, symbol: { type: "identity" },
  }));
}

function signalPlot(width, marginLeft, name, timeline, failures) {
  const end = timeline.end_s, points = withGaps(parsedSignal(timeline.signals[name], end), name, timeline);
  const measured = points.filter(([, value]) => value !== null);
  const unit = DATA.units[name], label = visible(name) + (unit ? " (" + visible(unit) + ")" : "");
  // The axis of a constant signal needs some height, too.
  const constant = measured.length > 0 && measured.every(([, value]) => value === measured[0][1]);
  const domain = constant ? { domain: [measured[0][1] - 0.5, measured[0][1] + 0.5] } : { nice: true };
  return Plot.plot(plain(width, {
    ariaLabel: label, marginLeft, marginTop: 22, marginBottom: 26, height: 120,
    x: { domain: [0, end], label: null, grid: true }, y: { label, grid: true, ticks: 4, ...domain },
    marks: [
      Plot.ruleX(failures, { x: "time", stroke: "var(--bad-mark)", strokeDasharray: "3 3" }),
      Plot.line(points, { x: "0", y: "1", curve: "step-after", stroke: "var(--c0)" }),
      Plot.tip(measured, Plot.pointerX({ x: "0", y: "1", title: (point) => seconds(point[0]) + ": " + point[1], fill: "var(--card)" })),
    ],
  }));
}

/** What a run's lanes, marks and colours mean. */
function timelineLegend(labelled) {
  const swatches = Object.entries(labelled).map(([lane, labels]) =>
    h("ul", { class: "legend" }, h("li", { class: "soft" }, lane + ":"), labels.map((label, n) => h("li", {}, h("i", { class: "swatch", style: "background:" + fillOf(n) }), label))));
  return [swatches, legend(Object.values(TRIGGERS).map(([outcome, colour]) => ["trigger " + outcome, colour, ""])),
    h("p", { class: "soft small" }, "A requirement's bar begins where it is triggered and ends where it is decided; × and the dashed line mark a violation. A dot is a message, ■ an action of the human, a dark bar a switch that is on. A signal keeps its value until it changes; signals are shown with fewer points, their extremes are kept. Of more than " + MOST_MARKS + " marks of a kind as many are drawn.")];
}

/** The whole timeline, or a message if there is none. */
function timelineView(found) {
  const { timeline, verdicts } = found;
  if (!timeline) return h("p", { class: "soft" }, "No timeline: the run was not completed.");
  const violations = verdicts.flatMap((verdict) => verdict.times.map((time) => ({ lane: verdict.name, name: verdict.name, time })));
  const failures = drawable(violations, timeline.end_s);
  const view = h("div", { class: "timeline" });
  const drawnLanes = lanes(found), room = roomFor(drawnLanes.names);
  drawn(view, (width) => lanePlot(width, timeline, drawnLanes, failures));
  for (const [name, text] of Object.entries(timeline.signals)) {
    if (!isSwitch(name, parsedSignal(text, timeline.end_s))) drawn(view, (width) => signalPlot(width, room, name, timeline, failures));
  }
  view.append(...timelineLegend(drawnLanes.labelled).flat());
  return view;
}
