// Source texts: a link opens a file, and keys lead from miss to miss, through all files.

/** The first lines of what is not covered, in the order of the page. */
function misses(view) {
  const isMiss = (row) => row && (row.classList.contains("missed") || row.classList.contains("partial"));
  const rows = [...view.querySelectorAll(".source tbody tr")].filter(isMiss);
  return rows.filter((row) => !isMiss(row.previousElementSibling) || row.className !== row.previousElementSibling.className);
}

function stepFrom(view) {
  const places = misses(view), bar = view.querySelector(".misses"), said = bar && bar.querySelector("span");
  let at = -1;
  if (!places.length) return () => {};
  bar.hidden = false;
  said.textContent = places.length + " in all.";
  return (step) => {
    if (at >= 0) places[at].classList.remove("current");
    at = at < 0 && step < 0 ? places.length - 1 : (at + step + places.length) % places.length;
    places[at].closest("details").open = true;
    places[at].classList.add("current");
    places[at].scrollIntoView({ block: "center" });
    said.textContent = (at + 1) + " of " + places.length + ".";
  };
}

/** What shows a view of sources, called with the title of the file to open, if any, and "@" with a line of it. */
function sourcesPage(view) {
  const step = stepFrom(view);
  view.querySelectorAll(".misses button").forEach((button) => button.addEventListener("click", () => step(Number(button.dataset.step))));
  document.addEventListener("keydown", (event) => {
    if (view.hidden || event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select, textarea")) return;
    if (event.key === "n") step(1);
    if (event.key === "p") step(-1);
  });
  return (title) => {
    const [, name, line] = /^(.*?)(?:@(\d+))?$/.exec(decodeURIComponent(title || ""));
    const file = name && [...view.querySelectorAll("details")].find((each) => each.dataset.title === name);
    if (!file) return;
    file.open = true;
    view.querySelectorAll(".source .current").forEach((row) => row.classList.remove("current"));
    const row = line && file.querySelector(".source tbody tr:nth-child(" + line + ")");
    if (!row) return file.scrollIntoView();
    row.classList.add("current");
    row.scrollIntoView({ block: "center" });
  };
}
