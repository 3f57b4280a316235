// How the search ranks what it finds: pages whose own title has words of the question first, API pages last.
var Scorer = {
  score: ([page, title, anchor, description, score]) => {
    const stemmer = new Stemmer();
    const stems = (text) => text.toLowerCase().split(/\W+/).filter((word) => word.length > 2).map((word) => stemmer.stemWord(word));
    const asked = new Set(stems(new URLSearchParams(window.location.search).get("q") || ""));
    const own = new Set(stems(title).filter((stem) => asked.has(stem)));
    return score + 20 * own.size - (page.startsWith("api/") ? 30 : 0);
  },
  // The rest is as in Sphinx.
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
