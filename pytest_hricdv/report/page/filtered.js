// Views whose rows can be searched, and chosen by their state; the address keeps both.

/** Lets a view's bar choose among its rows with a state; returns what shows them as an address has it. */
function filteredRows(view) {
  const bar = view.querySelector(".filter");
  const [search, state, shown] = ["[name=q]", "[name=state]", "[data-shown]"].map((name) => bar.querySelector(name));
  const bodies = [...view.querySelectorAll("tbody")].filter((body) => body.querySelector("[data-state]"));
  const draw = () => {
    const words = search.value.toLowerCase().split(/\s+/);
    let count = 0, all = 0;
    for (const body of bodies) {
      const rows = [...body.rows].filter((row) => "state" in row.dataset);
      for (const row of rows) {
        row.hidden = !words.every((word) => row.dataset.words.includes(word)) || (state.value !== "" && row.dataset.state !== state.value);
      }
      const kept = rows.filter((row) => !row.hidden).length;
      body.hidden = kept === 0;
      count += kept;
      all += rows.length;
    }
    shown.textContent = count < all ? count + " of " + all : "";
  };
  const change = () => { keepFilters({ q: search.value, state: state.value }); draw(); };
  search.addEventListener("input", change);
  state.addEventListener("change", change);
  bar.hidden = false;
  return (filters) => {
    search.value = filters.get("q") || "";
    state.value = filters.get("state") || "";
    draw();
  };
}
