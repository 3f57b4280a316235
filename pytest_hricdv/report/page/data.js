// The data of all tests, and loading of a single test's details.

const DATA = JSON.parse(document.getElementById("data").textContent);

const TESTS = DATA.rows.map((row, number) => ({
  number,
  anchor: row[0], id: row[1], suite: row[2], outcome: row[3], verdicts: row[4], triggers: row[5], margins: row[6],
  outcomes: row[7], percent: row[8], sim: row[9], beliefs: row[10], code: row[11], plans: row[12], actions: row[13],
}));

/** What each test is found by: its id, suite, outcome, actions, beliefs, causes, and the requirements that it failed. */
function searchedTexts() {
  const causes = TESTS.map(() => "");
  DATA.failedFor.forEach(({ title, tests }) => tests.forEach((number) => { causes[number] += " " + title; }));
  return TESTS.map((test) => {
    const failed = DATA.requirements.filter((_, n) => "FK".includes(test.verdicts[n])).map((name) => name + " " + (DATA.titles[name] || ""));
    return [test.id, DATA.suites[test.suite], DATA.outcomeWords[test.outcome], ...test.outcomes, test.beliefs,
      ...test.actions.map((n) => DATA.actions[n]), ...failed, causes[test.number]].join("\n").toLowerCase();
  });
}

const BY_ANCHOR = new Map(TESTS.map((test) => [test.anchor, test]));

/** Whether bit `n` of a hexadecimal number is set. */
function hasBit(hex, n) {
  const digit = hex.length - 1 - (n >> 2);
  return digit >= 0 && (parseInt(hex[digit], 16) >> (n & 3)) % 2 === 1;
}

const packs = new Map();
const arrivals = new Map();

// A page opened from disk must not fetch files, but may run scripts.
window.hricdvPack = (number, text) => arrivals.get(number)(text);

function load(number) {
  const embedded = document.getElementById("pack-" + number);
  if (embedded) return Promise.resolve(embedded.textContent);
  return new Promise((resolve, reject) => {
    arrivals.set(number, resolve);
    const file = "details/" + String(number).padStart(4, "0") + ".js";
    const missing = () => reject(new Error(file + " is missing beside this page"));
    document.head.append(h("script", { src: file, onerror: missing }));
  });
}

/** A promise of the lines of a pack: of each of its tests one, in JSON. */
async function unpacked(number) {
  const bytes = Uint8Array.from(atob(await load(number)), (char) => char.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return (await new Response(stream).text()).split("\n");
}

/** A promise of the details of a test. */
async function details(test) {
  const number = Math.floor(test.number / DATA.packSize);
  if (!packs.has(number)) packs.set(number, unpacked(number));
  try {
    return JSON.parse((await packs.get(number))[test.number % DATA.packSize]);
  } catch (error) {
    packs.delete(number);
    throw error;
  }
}
