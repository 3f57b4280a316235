// The code under test at the cursor of a failing run: where each node stands, and what it executed last.

// Lines of the source that are shown around where the code stands: a small function.
const CODE_ABOVE = 7, CODE_BELOW = 5;

/** Of each node the bursts of its run: [time, number of the burst] in the order of time. */
function nodeBursts({ nodes }) {
  return nodes.map((text) => {
    const numbers = text.split(" ").map(Number), bursts = [];
    for (let n = 0; n + 1 < numbers.length; n += 2) bursts.push([numbers[n], numbers[n + 1]]);
    return bursts;
  });
}

/** The lines of a burst: [file, line] in the order in which they were executed. */
function burstLines({ files, bursts }, number) {
  let file = "";
  return bursts[number].split(" ").map((text) => {
    const [place, line] = text.includes(":") ? text.split(":") : [null, text];
    if (place !== null) file = files[Number(place)];
    return [file, Number(line)];
  });
}

/** The lines of a file, as the view of the code has them; empty where the report has no such text. */
function sourceOf(file) {
  const text = [...document.querySelectorAll("#code details")].find((each) => each.dataset.title === file);
  return text ? [...text.querySelectorAll(".source tbody code")].map((each) => each.textContent) : [];
}

/** The function that a line is in, by its indentation; empty for none. */
function functionAt(source, line) {
  let depth = Infinity;
  for (let n = line; n > 0; n--) {
    const [, space, name] = /^(\s*)(?:(?:async )?def (\w+))?/.exec(source[n - 1]);
    if (!source[n - 1].trim() || space.length >= depth) continue;
    if (name) return name;
    depth = space.length;
  }
  return "";
}

/** The text around where a node stands: what it executed at its last burst is marked, the last line most. */
function codeAt(file, line, executed, sources) {
  if (!sources.has(file)) sources.set(file, sourceOf(file));
  const source = sources.get(file);
  if (!source.length) return h("p", { class: "soft small" }, "The report has no text of " + file + ".");
  const first = Math.max(1, line - CODE_ABOVE), last = Math.min(source.length, line + CODE_BELOW);
  return h("ol", { class: "code-lines", start: first, tabindex: "0", "aria-label": "Lines of " + file }, source.slice(first - 1, last).map((text, n) => {
    const here = first + n === line, ran = executed.has(file + ":" + (first + n));
    return h("li", { class: here ? "stands" : ran ? "ran" : "", "aria-current": here ? "true" : null }, h("code", {}, text || " "));
  }));
}

/** What each node did last before a time: [{time, lines}], the latest first. */
function nodesAt(lines, nodes, time) {
  return nodes.map((bursts) => {
    // Of bursts at one time the last one counts; a time is kept to a tenth of a millisecond.
    const at = bursts.findLast((burst) => burst[0] <= time + 1e-4);
    return at && { time: at[0], lines: burstLines(lines, at[1]) };
  }).filter(Boolean).sort((a, b) => b.time - a.time);
}

/** Where the code of the passing run stands at the same time. */
function standsThere(there, here) {
  const [file, line] = there.lines.at(-1), same = here && here.lines.at(-1).join(":") === file + ":" + line;
  const text = (sourceOf(file)[line - 1] ?? "").trim();
  return h("p", { class: same ? "small soft" : "small differs" }, "In the passing run it stands at ", h("span", { class: "mono" }, file + ":" + line), same ? ", too." : ": ", !same && h("code", {}, text));
}

function codePanel(found, run) {
  const { lines } = found;
  if (!lines) return null;
  const place = h("div", {}), element = h("div", { class: "code-at" }, h("h4", {}, "The code"), place), sources = new Map();
  if (!lines.files.length) {
    place.append(h("p", { class: "soft small" }, lines.note));
    return { element, at: () => {} };
  }
  const theirs = found.neighbour && found.neighbour.lines, theirNodes = theirs ? nodeBursts(theirs) : [];
  const nodes = nodeBursts(lines), from = lines.from_s ?? 0, until = lines.until_s ?? null;
  let shown = "";
  const at = (time) => {
    const cut = time < from || (until !== null && time > until);
    const now = cut ? [] : nodesAt(lines, nodes, time), there = theirs ? nodesAt(theirs, theirNodes, time)[0] : null;
    const key = cut + JSON.stringify([now, there && there.lines]);
    if (key === shown) return;
    shown = key;
    const parts = now.map((node, n) => {
      const [file, line] = node.lines[node.lines.length - 1], executed = new Set(node.lines.map((each) => each.join(":")));
      if (!sources.has(file)) sources.set(file, sourceOf(file));
      const name = functionAt(sources.get(file), line);
      const title = [h("span", { class: "mono" }, h("a", { href: "#code/" + encodeURIComponent(file) }, file + ":" + line)), name && [" in ", h("span", { class: "mono" }, name)], h("span", { class: "soft" }, ", since " + seconds(node.time))];
      return n ? h("details", { class: "small" }, h("summary", {}, title), codeAt(file, line, executed, sources)) : [h("p", { class: "small" }, title), codeAt(file, line, executed, sources)];
    });
    if (there) parts.push(standsThere(there, now[0]));
    place.replaceChildren(...[parts.length ? parts : h("p", { class: "soft small" }, cut ? "The run was long: its lines were kept from " + seconds(from) + " to " + seconds(until) + " only." : "The code has not begun yet."), lines.note && h("p", { class: "soft small" }, lines.note)].flat(Infinity).filter(Boolean));
  };
  return { element, at };
}

RUN_PANELS.push(codePanel);
