// Runs the module beside the page, so that the page stays awake. One request after the other; what is asked is text, see the crate
// rimbench-web. With `wanted`, only these columns come back, each as an array of its own.
let module;
let compiled;
const start = async () => {
  module = (await WebAssembly.instantiate(compiled, {})).exports;
};
const ask = (text) => {
  const bytes = new TextEncoder().encode(text);
  const place = module.room(bytes.length);
  new Uint8Array(module.memory.buffer, place, bytes.length).set(bytes);
  module.answer();
  const words = new TextDecoder().decode(new Uint8Array(module.memory.buffer, module.words(), module.words_length()));
  return { words, numbers: new Float64Array(module.memory.buffer, module.numbers(), module.numbers_length()) };
};
const cut = ({ words, numbers }, wanted) => {
  const names = (words.match(/^columns (.*)$/m)?.[1] ?? "").split(" "), width = names.length;
  const rows = Math.floor(numbers.length / width) || 0, columns = {};
  for (const name of wanted) {
    const k = names.indexOf(name);
    if (k >= 0) columns[name] = Float64Array.from({ length: rows }, (_, row) => numbers[row * width + k]);
  }
  return { words, columns, rows };
};
const answer = (request, wanted) => {
  const whole = ask(request);
  return wanted ? cut(whole, wanted) : { ...whole, numbers: whole.numbers.slice() };
};
onmessage = async ({ data }) => {
  if (data.module) {
    compiled = data.module;
    try {
      await start();
    } catch (error) {
      postMessage({ failed: error.message });
      return;
    }
    postMessage({ ready: ask("schemes").words, cases: ask("cases").words });
    return;
  }
  const answers = [];
  for (const request of data.requests) {
    try {
      answers.push(answer(request, data.wanted));
    } catch (error) {
      // What broke off may have left anything behind: a fresh module for the next.
      answers.push({ words: `error the run broke off: ${error.message}`, numbers: new Float64Array(), columns: {}, rows: 0 });
      await start();
    }
  }
  const arrays = answers.flatMap(({ numbers, columns }) => (numbers ? [numbers] : Object.values(columns)));
  postMessage({ answers, id: data.id }, arrays.map((array) => array.buffer));
};
