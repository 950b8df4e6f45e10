// Asks the search of the built documentation, without a browser: node site_search.js SITE < questions.json
const fs = require("fs");
const path = require("path");
const vm = require("vm");

const site = process.argv[2];
const onceLoaded = [];
const element = { dataset: { content_root: "./" } };
const context = vm.createContext({
  document: {
    documentElement: element,
    getElementById: () => null,
    readyState: "loading",
    addEventListener: (_event, run) => onceLoaded.push(run),
  },
  DOCUMENTATION_OPTIONS: {},
  SPHINX_HIGHLIGHT_ENABLED: false,
  URLSearchParams,
  _: (text) => text,
  _ready: () => {},
});
context.window = context;
const scripts = ["questions.js", "base-stemmer.js", "english-stemmer.js", "searchtools.js", "language_data.js"];
for (const script of [...scripts.map((name) => path.join("_static", name)), "searchindex.js"]) {
  const file = path.join(site, script);
  if (fs.existsSync(file)) vm.runInContext(fs.readFileSync(file, "utf8"), context);
}
onceLoaded.forEach((run) => run());
const found = {};
for (const question of JSON.parse(fs.readFileSync(0, "utf8"))) {
  context.question = question;
  const results = vm.runInContext("Search._performSearch(...Search._parseQuery(question))", context);
  found[question] = results.reverse().map(([page]) => page);
}
console.log(JSON.stringify(found));
