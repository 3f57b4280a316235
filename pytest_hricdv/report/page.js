(function () {
  "use strict";
  // Without scripts every test is listed, and the filter, which would do nothing, stays hidden.
  var form = document.getElementById("filter");
  if (!form) { return; }
  var tests = Array.prototype.slice.call(document.querySelectorAll("details.test"));
  var shown = document.getElementById("shown");
  form.hidden = false;
  function apply() {
    var text = form.elements.text.value.toLowerCase();
    var outcome = form.elements.outcome.value;
    var count = 0;
    tests.forEach(function (test) {
      var keep = (!outcome || test.dataset.outcome === outcome) && test.textContent.toLowerCase().indexOf(text) >= 0;
      test.hidden = !keep;
      count += keep ? 1 : 0;
    });
    shown.textContent = count + " of " + tests.length + " shown";
  }
  form.addEventListener("input", apply);
  form.addEventListener("submit", function (event) { event.preventDefault(); });
  function open() {
    var test = document.getElementById(location.hash.slice(1));
    if (test && test.tagName === "DETAILS") { test.hidden = false; test.open = true; test.scrollIntoView(); }
  }
  window.addEventListener("hashchange", open);
  apply();
  open();
})();
