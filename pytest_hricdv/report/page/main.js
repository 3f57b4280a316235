// Navigation: the part of the address after "#" says which page is shown, as in "requirement/R1" or "test/0a1b2c3d4e".

const views = [...document.querySelectorAll(".view")];
const opened = new Set();
const showTests = testsPage(document.getElementById("test-table"));
const showSources = { code: sourcesPage(document.getElementById("code")), plans: sourcesPage(document.getElementById("plans")) };

function viewOf(address) {
  const kind = address.split("/")[0];
  if (["test", "tests", "code", "plans"].includes(kind)) return document.getElementById(kind);
  const named = document.getElementById(address);
  return named && named.classList.contains("view") ? named : views[0];
}

function show() {
  const address = location.hash.slice(1), view = viewOf(address);
  for (const each of views) each.hidden = each !== view;
  for (const link of document.querySelectorAll("nav a")) {
    const mine = link.hash.slice(1) === (view.classList.contains("requirement") ? "requirements" : view.id);
    if (mine) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
    if (mine) link.scrollIntoView({ block: "nearest", inline: "nearest" });
  }
  const rest = address.split("/").slice(1);
  if (view.id === "tests") showTests(rest);
  else if (view.id === "test") testPage(view, rest[0]);
  else if (!opened.has(view)) {
    opened.add(view);
    const open = view.classList.contains("requirement") ? requirementPage : PAGES[view.id];
    if (open) open(view);
  }
  scrollTo(0, 0);
  if (view.id in showSources) showSources[view.id](rest.join("/"));
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

document.querySelectorAll("table.sortable").forEach(makeSortable);
startTheme();
addEventListener("hashchange", show);
document.documentElement.dataset.ready = "";
show();
