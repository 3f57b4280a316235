// How a test's run differs from the one before: both timelines, and the messages around the first difference.

const MESSAGES_BEFORE = 3, MESSAGES_AFTER = 9;

/** What stands between backquotes as code. */
function coded(text) {
  return text.split("`").map((part, n) => (n % 2 ? h("code", {}, part) : part));
}

/** Messages only: of the run before nothing else is kept. */
function messagesOf({ end_s, messages }) {
  return { end_s, messages, signals: {}, triggers: {} };
}

function behaviourView({ changed, timeline, abstract }) {
  const rest = changed.also.length > 0 && h("ul", { class: "small" }, changed.also.map((text) => h("li", {}, text)));
  const first = h("p", {}, "First difference: ", coded(changed.text), ".");
  if (!timeline || !changed.before.messages.length) return section("Compared with the " + changed.against, first, rest);
  const runs = [["Before", changed.before], ["This run", messagesOf(timeline)]];
  return section("Compared with the " + changed.against, first, rest, twoTimelines(runs, changed, abstract), messageTable(runs));
}

/** Both runs with the same lanes and the same axis of time; the first difference is marked in each. */
function twoTimelines(runs, changed, abstract) {
  const made = runs.map(([, timeline]) => lanes({ timeline, acted: [], abstract }));
  const names = [...new Set(made.flatMap((each) => each.names))], room = roomFor(names);
  const end_s = Math.max(...runs.map(([, timeline]) => timeline.end_s));
  const lane = DATA.state && changed.topic === DATA.state.split(".")[0] ? "state" : changed.topic;
  const marks = changed.time === null ? [] : [{ lane, name: lane, time: changed.time }];
  const figures = runs.map(([title], n) => {
    const figure = h("figure", {}, h("h4", {}, title));
    drawn(figure, (width) => lanePlot(width, room, [0, end_s], made[n], names, marks));
    drawn(figure, (width) => axisPlot(width, room, [0, end_s]));
    return figure;
  });
  return h("div", { class: "figures" }, figures);
}

/** The messages around the first that differs, side by side. */
function messageTable(runs) {
  const [before, now] = runs.map(([, timeline]) => timeline.messages.map(messageText));
  let first = 0;
  while (first < Math.max(before.length, now.length) && before[first] === now[first]) first += 1;
  if (first === Math.max(before.length, now.length)) return null;
  const start = Math.max(0, first - MESSAGES_BEFORE), stop = Math.min(Math.max(before.length, now.length), first + MESSAGES_AFTER);
  const rows = Array.from({ length: stop - start }, (_, n) => start + n).map((n) =>
    h("tr", { class: before[n] === now[n] ? "soft" : n === first ? "missed" : "" },
      [before[n], now[n]].map((text) => h("td", { class: "mono" }, text || "-"))));
  return [h("h4", {}, "Messages " + (start + 1) + " to " + stop),
    tableOf({ class: "beside" }, runs.map(([title]) => title), rows)];
}

function messageText(text) {
  const [{ time, sender, topic, fields }] = parsedMessages({ messages: [text] });
  const values = Object.entries(fields).sort().map(([name, value]) => name + "=" + value);
  return [time.toFixed(3) + " s", sender, topic, ...values].join(" ");
}
