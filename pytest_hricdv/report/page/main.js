// Navigation: the part of the address after "#" says which page is shown, as in "requirement/R1" or "test/0a1b2c3d4e".

const views = [...document.querySelectorAll(".view")];
const opened = new Set();
const showRows = new Map(views.filter((view) => view.querySelector(".filter")).map((view) => [view, filteredRows(view)]));
const showTests = testsPage(document.getElementById("test-table"));
const showSources = { code: sourcesPage(document.getElementById("code")), plans: sourcesPage(document.getElementById("plans")) };
const TITLE = document.title;

/** The view of an address, and the element in it that the address is of, if it is not the view's own. */
function viewOf(path) {
  const kind = path.split("/")[0];
  if (["test", "tests", "code", "plans"].includes(kind)) return [document.getElementById(kind), null];
  const named = document.getElementById(path), view = named && named.closest(".view");
  return view ? [view, view === named ? null : named] : [views[0], null];
}

/** Marks the links of the navigation that lead to this view, and shows what is listed beside it. */
function markLinks(view) {
  const mine = view.classList.contains("requirement") ? "requirements" : view.id === "test" ? "tests" : view.id;
  const within = [...document.querySelectorAll("nav.within")];
  const leads = (link) => link.hash.slice(1) === mine;
  const around = within.find((nav) => [...nav.querySelectorAll("a")].some(leads));
  for (const nav of within) nav.hidden = nav !== around;
  for (const link of document.querySelectorAll("header nav a")) {
    const inTop = !link.closest(".within"), area = link.hash.slice(1);
    if (leads(link)) link.setAttribute("aria-current", "page");
    else if (inTop && around && around.dataset.of === area) link.setAttribute("aria-current", "true");
    else link.removeAttribute("aria-current");
    const nav = link.parentElement; // on a narrow screen it is one row, which may have to be swept
    if (link.hasAttribute("aria-current")) nav.scrollLeft = link.offsetLeft - nav.offsetLeft - (nav.clientWidth - link.offsetWidth) / 2;
  }
}

function headingOf(view) {
  return view.querySelector("h2") || view;
}

/** Moves the keyboard's place to what is shown now: to the link that was followed before, else to the view's heading. */
function focusView(view, left) {
  const link = left && [...view.querySelectorAll("a")].find((each) => each.hash.replace(/@.*/, "") === left.replace(/@.*/, "") && each.checkVisibility());
  const target = link || headingOf(view);
  if (!link) target.tabIndex = -1;
  target.focus({ preventScroll: true });
}

function nameOf(view) {
  const heading = headingOf(view).cloneNode(true);
  for (const aside of heading.querySelectorAll(".small, .badge")) aside.remove();
  return heading.textContent.trim();
}

/** Shows what a view has of an address; a promise where that has to be loaded. */
function fill(view, { parts, filters }) {
  const rest = parts.slice(1);
  if (view.id === "tests") return showTests(rest, filters);
  if (view.id === "test") return testPage(view, rest[0]);
  if (showRows.has(view)) showRows.get(view)(filters);
  if (!opened.has(view)) {
    opened.add(view);
    const open = view.classList.contains("requirement") ? requirementPage : PAGES[view.id];
    if (open) open(view);
  }
  return undefined;
}

async function show(event) {
  const address = addressed(), [view, part] = viewOf(address.path), left = places.at, mine = ++places.shown, kept = history.state, root = document.documentElement;
  places.at = location.hash;
  places.fills = true;
  root.style.overflowAnchor = "none"; // what grows above must not move the page
  for (const each of views) each.hidden = each !== view;
  markLinks(view);
  const filled = fill(view, address);
  document.title = nameOf(view) + " · " + TITLE;
  const isBack = backAtPlace(kept);
  if (!isBack) scrollTo(0, 0);
  if (event) focusView(view, isBack && left);
  if (filled) await filled;
  if (mine !== places.shown) return; // meanwhile something else is
  if (filled && event && !view.contains(document.activeElement)) focusView(view, null); // the heading is another one
  document.title = nameOf(view) + " · " + TITLE;
  if (view.id in showSources) showSources[view.id](address.parts.slice(1).join("/"));
  for (let at = part && part.closest("details"); at; at = at.parentElement.closest("details")) at.open = true;
  if (!isBack && part) part.scrollIntoView();
  // Plots get their heights a frame later.
  requestAnimationFrame(() => requestAnimationFrame(() => {
    if (mine !== places.shown) return;
    if (isBack) backAtPlace(kept);
    places.fills = false;
    root.style.overflowAnchor = "";
  }));
}

function chooseTheme(scheme) {
  document.documentElement.style.colorScheme = scheme;
}

function startTheme() {
  const choice = document.getElementById("theme");
  let saved = null;
  try { saved = localStorage.getItem("hricdv-theme"); } catch { /* a page opened from disk may have no storage */ }
  if (saved) { choice.value = saved; chooseTheme(saved); }
  choice.closest("label").hidden = false;
  choice.addEventListener("change", () => {
    chooseTheme(choice.value);
    try { localStorage.setItem("hricdv-theme", choice.value); } catch { /* not kept */ }
  });
}

/** How high the page's header is, for what stays below it. */
function measureHeader() {
  const header = document.querySelector("header.top"), root = document.documentElement;
  new ResizeObserver(() => root.style.setProperty("--header", (getComputedStyle(header).position === "sticky" ? header.offsetHeight : 0) + "px")).observe(header);
}

function startSkipping() {
  document.querySelector(".skip").addEventListener("click", (event) => {
    event.preventDefault();
    const view = views.find((each) => !each.hidden);
    focusView(view, null);
    headingOf(view).scrollIntoView();
  });
}

/** What a cell of one line has no room for comes up below the pointer: all of it, or the longer text that it names. */
function startTips() {
  const isCut = (cell) => cell.scrollWidth > cell.clientWidth || cell.scrollHeight > cell.clientHeight + 1;
  const text = (cell) => cell.dataset.full || [...cell.cloneNode(true).childNodes];
  tipOver(document.getElementById("main"), ".cut", text, (cell) => cell.getBoundingClientRect(), (cell) => "full" in cell.dataset || isCut(cell));
}

document.querySelectorAll("table.sortable").forEach(makeSortable);
document.querySelectorAll(".command > pre").forEach((text) => text.parentElement.replaceWith(command(text.textContent)));
for (const button of document.querySelectorAll("[data-print]")) {
  button.closest("[hidden]").hidden = false;
  button.addEventListener("click", () => print());
}
startTips();
startTheme();
startSkipping();
startSearch();
startKeys();
measureHeader();
watchPlaces();
addEventListener("hashchange", show);
document.documentElement.dataset.ready = "";
show();
