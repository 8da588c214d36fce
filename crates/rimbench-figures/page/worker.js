// Runs the module beside the page, so that the page stays awake. One request after the other; what is asked is text, see the crate
// rimbench-web.
let module;
let bytes;
const start = async () => {
  module = (await WebAssembly.instantiate(bytes, {})).instance.exports;
};
const ask = (text) => {
  const bytes = new TextEncoder().encode(text);
  const place = module.room(bytes.length);
  new Uint8Array(module.memory.buffer, place, bytes.length).set(bytes);
  module.answer();
  const words = new TextDecoder().decode(new Uint8Array(module.memory.buffer, module.words(), module.words_length()));
  const numbers = new Float64Array(module.memory.buffer, module.numbers(), module.numbers_length()).slice();
  return { words, numbers };
};
onmessage = async ({ data }) => {
  if (data.module) {
    bytes = data.module;
    try {
      await start();
    } catch (error) {
      postMessage({ failed: error.message });
      return;
    }
    postMessage({ ready: ask("schemes").words });
    return;
  }
  const answers = [];
  for (const request of data.requests) {
    try {
      answers.push(ask(request));
    } catch (error) {
      // What broke off may have left anything behind: a fresh module for the next.
      answers.push({ words: `error the run broke off: ${error.message}`, numbers: new Float64Array() });
      await start();
    }
  }
  postMessage({ answers }, answers.map((answer) => answer.numbers.buffer));
};
