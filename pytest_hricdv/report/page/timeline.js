// What is drawn of a run over simulated time: the lanes of its state, actors, messages, switches and requirements.

const TRIGGERS = { "": ["passed", "var(--ok-mark)"], "!": ["failed", "var(--bad-mark)"], "?": ["pending at the end", "var(--nc-mark)"] };

// Marks of a lane. There are fewer columns of pixels to tell them apart by, and a browser is busy for minutes with a
// million of them.
const MOST_MARKS = 2000;

/** The marks to draw: of a lane with too many, the first in each of as many spans of time, one that failed before others. */
function drawable(marks, [begin, end]) {
  const counts = {}, kept = new Map();
  for (const { lane } of marks) counts[lane] = (counts[lane] || 0) + 1;
  marks.forEach((mark, n) => {
    const span = Math.floor((((mark.time ?? mark.from) - begin) / (end - begin)) * MOST_MARKS);
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
  if (label.length <= Math.floor(pixels / 7)) return label;
  const most = Math.floor((pixels - 5) / 7); // the dots are wider than a letter
  return most < 3 ? "" : label.slice(0, most - 1) + "…";
}

/** Who acts in an abstract test, where its lines say so: "nurse: press call". */
function actorsOf(abstract) {
  return [...new Set(abstract.map((line) => (/^(\w+): /.exec(line) ?? [])[1]).filter(Boolean))];
}

/** The lane of a line: that of its actor; of several actors, what is none of theirs is the test's. */
function laneOf(line, abstract) {
  return (/^(\w+): /.exec(line) ?? [])[1] ?? (actorsOf(abstract).length ? "the test" : "the human");
}

/** The lanes of a run under construction: their marks, kinds and labels. */
class Lanes {
  /** `labelled`: lane -> labels of another run, whose colours this one is to have, too. */
  constructor(labelled = {}) {
    this.before = labelled;
    this.names = [];
    this.kinds = {};
    this.labelled = {};
    this.bars = [];
    this.dots = [];
  }

  add(name, kind) {
    if (this.names.includes(name)) return;
    this.names.push(name);
    this.kinds[name] = kind;
  }

  /** Spans with a label each, of a state or another text. */
  addSpans(lane, kind, spans) {
    const labels = [...new Set([...(this.before[lane] ?? []), ...spans.map((span) => span.label)])];
    if (!spans.length) return;
    this.add(lane, kind);
    this.labelled[lane] = labels;
    for (const span of spans) {
      this.bars.push({ lane, ...span, fill: fillOf(labels.indexOf(span.label)), event: lane + " " + span.label, tooltip: span.label + "\n" + seconds(span.from) + " to " + seconds(span.to) });
    }
  }

  addAct(lane, time, text, fill) {
    this.dots.push({ lane, time, symbol: "square", fill, name: text.replace(/^\d+ /, "").replace(lane + ": ", ""), event: text, tooltip: seconds(time) + ": " + text });
  }

  addMessage({ time, sender, topic, fields }) {
    const disturbs = topic.includes(" "), lane = disturbs ? "disturbances" : topic;
    const values = Object.entries(fields).map(([name, value]) => name + " " + value).join(", ");
    const event = sender + (disturbs ? ": " : " sends ") + topic;
    this.add(lane, disturbs ? "disturbance" : "message");
    this.dots.push({ lane, time, symbol: disturbs ? "diamond" : "circle", fill: disturbs ? "var(--c1)" : "var(--c0)", event: event + (values ? ": " + values : ""), tooltip: seconds(time) + ": " + event + "\n" + values });
  }

  addSwitch(name, points) {
    this.add(name, "switch");
    points.slice(0, -1).forEach(([from, value], n) => {
      const to = points[n + 1][0];
      if (value) this.bars.push({ lane: name, from, to, fill: "var(--c5)", event: name + " on", ended: name + " off", tooltip: name + " from " + seconds(from) + " to " + seconds(to) });
    });
  }

  addTriggers(name, text) {
    this.add(name, "requirement");
    for (const { begin, end: over, mark } of parsedTriggers(text)) {
      const [outcome, colour] = TRIGGERS[mark], failed = mark === "!";
      const tooltip = name + " triggered at " + seconds(begin) + "\n" + outcome + " at " + seconds(over);
      this.bars.push({ lane: name, from: begin, to: over, fill: colour, tooltip, failed, ended: name + " " + outcome });
      this.dots.push({ lane: name, time: begin, symbol: failed ? "triangle" : "circle", fill: colour, tooltip, failed, event: name + " triggered" });
    }
  }
}

// What adds lanes of optional features: (found, lanes) => nothing.
const RUN_LANES = [];

/** The lanes of a run, from top to bottom: its state, who acts, messages, texts, switches, requirements. `labelled`: see `Lanes`. */
function lanes(found, labelled = {}) {
  const { timeline, acted, abstract, seen = [] } = found;
  const messages = parsedMessages(timeline), end = timeline.end_s, made = new Lanes(labelled);
  const states = DATA.state ? stateSpans(messages, end) : [];
  const stateTopic = states.length ? DATA.state.split(".")[0] : null;
  made.addSpans("state", "state", states);
  if (acted.length) (actorsOf(abstract).length ? actorsOf(abstract) : ["the human"]).forEach((name) => made.add(name, "actor"));
  acted.forEach((time, n) => {
    if (typeof time !== "number") return;
    made.add(laneOf(abstract[n], abstract), "actor");
    made.addAct(laneOf(abstract[n], abstract), time, n + 1 + " " + abstract[n], "var(--c2)");
  });
  for (const [time, act] of seen) {
    made.add(laneOf(act, [act]), "actor");
    made.addAct(laneOf(act, [act]), time, act, "var(--c3)");
  }
  messages.filter((message) => message.topic !== stateTopic).forEach((message) => made.addMessage(message));
  for (const [name, changes] of Object.entries(timeline.texts ?? {})) made.addSpans(name, "text", textSpans(changes, end));
  for (const [name, text] of Object.entries(timeline.signals)) {
    const points = parsedSignal(text, end);
    if (isSwitch(name, points)) made.addSwitch(name, points);
  }
  for (const [name, text] of Object.entries(timeline.triggers).sort(([a], [b]) => natural(a, b))) made.addTriggers(name, text);
  RUN_LANES.forEach((add) => add(found, made));
  return made;
}
