"use strict";

const PERIOD_MS = 1000;
const byId = (name) => document.getElementById(name);
let shown = 0;

/** An element with a text: nothing that a session wrote becomes markup. */
function element(name, text, className = "") {
  const made = document.createElement(name);
  made.textContent = text;
  made.className = className;
  return made;
}

function headline(state) {
  if (state.problem) return "Cannot be read";
  if (state.what === undefined) return "Waiting: nothing has begun";
  const noun = state.what === "session" ? "tests" : "runs";
  return `${state.over ? "Ended: " : ""}${state.what}: ${state.done} of ${state.total} ${noun}`;
}

function show(state) {
  byId("headline").textContent = headline(state);
  document.title = `${headline(state)}: pytest-hricdv`;
  byId("problems").textContent = state.problem || "";
  if (state.what === undefined) return;
  byId("bar").max = state.total || 1;
  byId("bar").value = state.done;
  byId("bar").className = state.causes.length ? "failed" : "";
  const facts = [state.workers, state.left, state.silent, state.open.length ? `open: ${state.open.join(", ")}` : ""];
  byId("facts").textContent = [state.name, ...facts].filter(Boolean).join(" · ");
  const told = state.verdicts.filter(([, , failed]) => failed || !state.has_page); // the page has the others
  const rows = told.map(([name, passed, failed, unchecked]) => {
    const row = element("tr", "");
    row.append(element("th", name), element("td", `${passed} passed`));
    row.append(element("td", `${failed} failed`, failed ? "failed" : ""), element("td", `${unchecked} NC`));
    return row;
  });
  byId("verdicts").hidden = !rows.length;
  byId("verdicts").tBodies[0].replaceChildren(...rows);
  byId("causes").hidden = !state.causes.length;
  byId("causes").querySelector("ul").replaceChildren(...state.causes.map((text) => element("li", text)));
}

/** Reloads the page at its scroll position, unless it is still loading. */
function load(version) {
  const frame = byId("page");
  if (version === shown || frame.dataset.loading) return;
  const old = frame.hidden ? null : frame.contentWindow;
  const place = old ? [old.location.hash, old.scrollX, old.scrollY] : ["", 0, 0];
  frame.dataset.loading = "yes";
  frame.addEventListener("load", () => {
    delete frame.dataset.loading;
    frame.contentWindow.scrollTo(place[1], place[2]);
  }, { once: true });
  frame.hidden = false;
  frame.src = `report/index.html?${version}${place[0]}`;
  shown = version;
}

async function look() {
  try {
    const state = await (await fetch("status")).json();
    show(state);
    if (state.has_page) load(state.version);
    else byId("page").hidden = true;
  } catch (error) {
    byId("headline").textContent = "The server has ended";
  }
  setTimeout(look, document.hidden ? 10 * PERIOD_MS : PERIOD_MS);
}

look();
