// A run on one screen: lanes and signals over a window of time, a cursor in it, and beside it what held there.

// Panels beside the lanes, of optional features: (found, run) => {element, at(time, by), isFirst}, or null.
const RUN_PANELS = [];
// What gives the run that is shown beside a test's: found => {title, note, run: {timeline, acted, abstract}}, or null.
const RUNS_BESIDE = [];
// The lanes' element takes the click this many pixels around an event for one on the event.
const NEAR_PIXELS = 6;
// Browsers allow few changes of the history a second, and a cursor that is dragged moves often.
const KEPT_AFTER_MS = 150;

let openRun = null;

/** A span of time that is being dragged over; it is shaded meanwhile. */
class DraggedSpan {
  constructor(run, event) {
    Object.assign(this, { run, from: event.clientX, shade: h("div", { class: "dragged", "aria-hidden": "true" }) });
    run.place.append(this.shade);
  }

  extend({ clientX }) {
    const left = this.run.place.getBoundingClientRect().left;
    this.shade.style.left = Math.min(this.from, clientX) - left + "px";
    this.shade.style.width = Math.abs(clientX - this.from) + "px";
  }

  /** The window becomes the span; a click only, which is no span, moves the cursor. */
  end(event) {
    this.shade.remove();
    if (event.type === "pointercancel") return;
    const [begin, end] = [this.from, event.clientX].map((clientX) => this.run.timeAt({ clientX })).sort((a, b) => a - b);
    if (Math.abs(event.clientX - this.from) > NEAR_PIXELS) this.run.window.show(begin, end);
    else this.run.window.move(begin, "pointer");
  }
}

class RunView {
  constructor(test, found) {
    const { timeline } = found;
    Object.assign(this, { test, found, made: lanes(found), window: new RunWindow(timeline.end_s), curves: curvesOf(timeline), all: false });
    this.failures = found.verdicts.flatMap((verdict) => verdict.times.map((time) => ({ lane: verdict.name, name: verdict.name, time })));
    this.violations = [...new Set(this.failures.map((failure) => failure.time))].sort((a, b) => a - b);
    this.events = runEvents(this.made, this.failures);
    this.matter = mattering(found);
    this.other = otherRun(found, this.made.labelled);
    this.room = roomFor(this.made.names);
    this.element = this.build();
    this.window.zoomed.push(() => this.draw());
    this.window.moved.push((by) => this.mark(by));
    new ResizeObserver(() => { if (this.place.clientWidth !== this.width) this.draw(); }).observe(this.place);
  }

  names() {
    const { names, kinds } = this.made;
    return names.filter((name) => this.all || opensFirst(name, kinds[name], this.matter));
  }

  signals() {
    return this.curves.filter(({ name }) => this.all || !this.matter || this.matter.has(name));
  }

  build() {
    const button = (text, label, key, act) => h("button", { type: "button", "aria-label": label, title: label + " (key " + key + ")", onclick: act }, text);
    this.said = h("output", { class: "soft small" });
    this.tools = h("div", { class: "tools", role: "group", "aria-label": "Cursor and window" },
      button("◀", "Event before", "←", () => this.step(-1)), button("▶", "Next event", "→", () => this.step(1)),
      this.violations.length > 0 && button(this.violations.length > 1 ? "Next violation" : "Violation", "10 s around the violation", "v", () => this.toViolation()),
      button("Whole run", "Whole run", "0", () => this.window.show(0, this.window.end)),
      button("+", "Zoom in", "+", () => this.window.zoom(0.5)), button("−", "Zoom out", "-", () => this.window.zoom(2)), this.said);
    this.axis = h("div", { class: "axis", role: "slider", tabindex: "0", "aria-label": "Cursor, in seconds of simulated time", "aria-valuemin": "0", "aria-valuemax": String(this.window.end) });
    this.rows = h("div", { class: "timeline" });
    this.line = h("div", { class: "cursor", "aria-hidden": "true" }, h("span", {}));
    this.more = h("button", { type: "button", class: "more", onclick: () => { this.all = !this.all; this.draw(); } });
    this.place = h("div", { class: "lanes" }, this.axis, this.rows, this.line);
    this.place.addEventListener("pointerdown", (event) => this.press(event));
    this.place.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.panels = RUN_PANELS.map((panel) => panel(this.found, this)).filter(Boolean);
    this.at = h("div", { class: "at" });
    this.held = h("div", {});
    const of = (isFirst) => this.panels.filter((panel) => Boolean(panel.isFirst) === isFirst).map((panel) => panel.element);
    return h("section", { class: "card run", "aria-label": "The run", "aria-live": "off" }, this.tools,
      h("div", { class: "screen" }, h("div", { class: "left" }, this.place, this.more),
        h("div", { class: "beside-lanes", tabindex: "0", role: "region", "aria-label": "At the cursor" }, of(true), this.at, of(false), this.held)),
      h("details", { class: "small" }, h("summary", {}, "What lanes, marks and colours mean; keys"), timelineLegend(this.made.labelled), keyList()));
  }

  /** Draws what the window shows. */
  draw() {
    const width = Math.floor(this.place.clientWidth), { shown } = this.window;
    if (!width) return;
    this.width = width;
    const names = this.names(), signals = this.signals(), hidden = this.made.names.length + this.curves.length - names.length - signals.length;
    this.axis.replaceChildren(axisPlot(width, this.room, shown));
    const signal = (curve) => signalPlot(width, this.room, shown, curve, limitsOf(curve.name, curve.points, this.found), this.failures, this.other?.points(curve.name));
    this.rows.replaceChildren(lanePlot(width, this.room, shown, this.made, names, this.failures), ...signals.map(signal),
      ...(this.other ? otherLanes(this, names, width) : []));
    this.more.hidden = !this.matter || (!this.all && !hidden);
    this.more.textContent = this.all ? "Only lanes of failed requirements" : hidden + (hidden === 1 ? " more lane" : " more lanes");
    this.more.setAttribute("aria-expanded", String(this.all));
    this.mark("");
  }

  x(time) {
    const [begin, end] = this.window.shown;
    return this.room + ((time - begin) / (end - begin)) * (this.width - this.room - RIGHT);
  }

  timeAt(event) {
    const [begin, end] = this.window.shown, x = event.clientX - this.place.getBoundingClientRect().left;
    const time = begin + ((x - this.room) / (this.width - this.room - RIGHT)) * (end - begin);
    const near = this.stops().filter((stop) => Math.abs(this.x(stop) - x) <= NEAR_PIXELS);
    return near.length ? near.reduce((best, stop) => (Math.abs(stop - time) < Math.abs(best - time) ? stop : best)) : time;
  }

  /** In the lanes the cursor follows the pointer; along the axis of time, the span that is dragged over becomes the window. */
  press(event) {
    if (event.button !== 0 || !this.width || event.target.closest("button, a, .other")) return;
    const selection = event.target.closest(".axis") && new DraggedSpan(this, event);
    const drag = (moved) => (selection ? selection.extend(moved) : this.window.move(this.timeAt(moved), "pointer"));
    const end = (last) => {
      removeEventListener("pointermove", drag);
      removeEventListener("pointerup", end);
      removeEventListener("pointercancel", end);
      if (selection) selection.end(last);
    };
    drag(event);
    addEventListener("pointermove", drag);
    addEventListener("pointerup", end);
    addEventListener("pointercancel", end);
  }

  /** With Ctrl or Shift the wheel zooms; without, the page scrolls. */
  wheel(event) {
    if (!event.ctrlKey && !event.shiftKey) return;
    event.preventDefault();
    this.window.zoom((event.deltaY || event.deltaX) > 0 ? 1.25 : 0.8, this.timeAt(event));
  }

  /** The times that arrow keys stop at: of the events in open lanes. */
  stops() {
    const open = new Set(this.names());
    return [...new Set(this.events.filter((event) => open.has(event.lane)).map((event) => event.time))];
  }

  step(direction) {
    const stops = this.stops(), { time } = this.window;
    const next = direction > 0 ? stops.find((stop) => stop > time) : stops.findLast((stop) => stop < time);
    if (next !== undefined) this.window.move(next, "key");
  }

  /** To the next violation, after the last one to the first. */
  toViolation() {
    const next = this.violations.find((time) => time > this.window.time) ?? this.violations[0];
    this.go(next);
  }

  go(time) {
    this.window.around(time);
    this.window.move(time, "link");
  }

  /** Where the view begins: at the time of its address, else at the first violation, else at the begin of the run. */
  start(time) {
    if (time === null && !this.violations.length) return this.window.move(0, "start");
    if (time !== null && !this.violations.length) return this.window.move(time, "start");
    this.window.around(time ?? this.violations[0]);
    return this.window.move(time ?? this.violations[0], "start");
  }

  /** Puts the cursor's time into the address, without a step of the browser's history. */
  keepTime() {
    clearTimeout(this.waits);
    this.waits = setTimeout(() => {
      // Where the address is another one than what is shown, somebody is on the way to another view.
      if (openRun !== this || !this.element.clientWidth || places.at !== location.hash) return;
      // Another test may have been asked for, and still be on its way.
      if (testAt(unescaped(location.hash.replace(/^#test\//, ""))).test !== this.test) return;
      history.replaceState(history.state, "", "#test/" + this.test.anchor + "@" + Number(this.window.time.toFixed(3)));
      places.at = location.hash;
    }, KEPT_AFTER_MS);
  }

  /** Shows the cursor where it is, and what held there. */
  mark(by) {
    if (!this.width) return;
    const { time, shown } = this.window, happened = this.events.filter((event) => Math.abs(event.time - time) < 5e-4);
    this.line.style.left = this.x(time) + "px";
    this.line.hidden = time < shown[0] || time > shown[1];
    this.line.firstChild.textContent = time.toFixed(2) + " s";
    this.said.textContent = seconds(shown[0]) + " to " + seconds(shown[1]) + " of " + seconds(this.window.end);
    const state = barAt(this.made, "state", time);
    this.axis.setAttribute("aria-valuenow", String(time));
    this.axis.setAttribute("aria-valuetext", visible([seconds(time), state && "state " + state.label, ...happened.slice(0, 3).map((event) => event.text)].filter(Boolean).join(", ")));
    this.at.replaceChildren(...happenedAt(this, happened));
    this.held.replaceChildren(heldAt(this));
    this.panels.forEach((panel) => panel.at(time, by));
    if (by && by !== "start") this.keepTime();
  }
}

/** What happened at the cursor, that of open lanes first. */
function happenedAt(run, happened) {
  const open = new Set(run.names()), shown = happened.filter((event) => open.has(event.lane)), others = happened.filter((event) => !open.has(event.lane));
  const item = (event) => h("li", { class: event.failed ? "negative" : "" }, h("span", { class: "cut clamped" }, event.text));
  return [h("h3", {}, "At " + Number(run.window.time.toFixed(3)) + " s"),
    happened.length ? h("ul", { class: "happened small" }, shown.map(item)) : h("p", { class: "soft small" }, "Nothing happens at this instant; → leads to the next event."),
    others.length > 0 && h("details", { class: "small soft" }, h("summary", {}, plural(others.length, "event") + " of other lanes"), h("ul", { class: "happened" }, others.map(item)))].filter(Boolean);
}

/** The state, switches, texts and signals of open lanes at the cursor: [name, value] each. */
function valuesAt(run, made, pointsOf) {
  const { time } = run.window, rows = [];
  for (const lane of run.names()) {
    const kind = run.made.kinds[lane], bar = kind === "requirement" ? null : barAt(made, lane, time);
    if (kind === "state" || kind === "text") rows.push([lane, bar ? bar.label : "-"]);
    if (kind === "switch") rows.push([lane, bar ? "on" : "off"]);
  }
  for (const { name } of run.signals()) {
    const value = valueAt(pointsOf(name) ?? [], time), unit = DATA.units[name];
    rows.push([name, value === null ? "not measured" : value + (unit ? " " + unit : "")]);
  }
  return rows;
}

/** What held at the cursor, in the run and in the one beside it; what differs is marked. */
function heldAt(run) {
  const { made, other, window: { time } } = run;
  const rows = valuesAt(run, made, (name) => run.curves.find((curve) => curve.name === name).points);
  const others = other ? valuesAt(run, other.made, other.points) : [];
  for (const lane of run.names().filter((name) => made.kinds[name] === "requirement")) {
    const violated = run.failures.find((failure) => failure.name === lane)?.time, { text, failed } = verdictAt(made, lane, violated, time);
    rows.push([lane, text, failed]);
    if (other) others.push([lane, verdictAt(other.made, lane, undefined, time).text]);
  }
  const row = ([name, value, failed], n) => h("tr", { class: other && others[n][1] !== value ? "differs" : "" }, h("th", { scope: "row" }, name), h("td", { class: failed ? "negative" : "" }, value), other && h("td", {}, others[n][1]));
  return h("table", { class: "values small" }, other && h("thead", {}, h("tr", {}, h("td"), h("th", { scope: "col" }, "this run"), h("th", { scope: "col" }, "passing run"))), h("tbody", {}, rows.map(row)));
}

const RUN_KEYS = {
  ArrowLeft: (run) => run.step(-1), ArrowRight: (run) => run.step(1), Home: (run) => run.window.move(0, "key"), End: (run) => run.window.move(run.window.end, "key"),
  v: (run) => run.violations.length && run.toViolation(), 0: (run) => run.window.show(0, run.window.end), "+": (run) => run.window.zoom(0.5), "-": (run) => run.window.zoom(2),
};

function keyList() {
  return h("p", { class: "soft" }, h("kbd", {}, "?"), " lists the keys. The page's address contains the cursor's time: copy it to share this instant.");
}

document.addEventListener("keydown", (event) => {
  if (!openRun || !openRun.element.isConnected || !openRun.element.clientWidth || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target.closest("input, select, textarea, video, summary") || !(event.key in RUN_KEYS)) return;
  event.preventDefault();
  RUN_KEYS[event.key](openRun);
});

/** The run, or a message if there is none. `time`: where its cursor is at first; null for the violation. */
function runSection(test, found, time) {
  openRun = null;
  if (!found.timeline) return section("The run", h("p", { class: "soft" }, "No timeline: the run was not completed."));
  openRun = new RunView(test, found);
  openRun.start(time);
  return openRun.element;
}
