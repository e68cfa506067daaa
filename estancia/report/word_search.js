// SPDX-License-Identifier: Apache-2.0
// What words mean on this map: the associations that the page holds (packAssociations() in words/), looked up.
const wordSearch = (() => {
  'use strict';
  const data = JSON.parse(document.getElementById('data').textContent);
  // as LabelSearch has them; `otherwise`: a label that a word does not list is less probable than `least`
  const least = 0.3, nearTheBest = 0.5, shareOfSeveral = 0.4, otherwise = 0.05;
  // words alone, without the s of a plural (sameWords())
  const split = text => text.toLowerCase().replace(/[‘’]/g, "'").split(/[^a-z0-9'\u0080-\uffff]+/)
    .map(word => word.replace(/^'+|'+$/g, '')).filter(Boolean);
  const plain = text => split(text.replace(/['‘’]/g, '')).map(word => word.replace(/([^s])s$/, '$1')).join(' ');

  // word → [[label, probability], …], most probable first
  const known = new Map(), grammar = new Set();
  if (data.words) {
    let word = '';
    for (const [, shared, rest, list] of data.words.text.matchAll(/([0-9A-Z])([a-z' ]+)((?:[0-9A-Z]{4})*)/g)) {
      word = word.slice(0, parseInt(shared, 36)) + rest;
      known.set(word, (list.match(/.{4}/g) || []).map(four =>
        [data.words.labels[parseInt(four.slice(0, 2), 36)], parseInt(four.slice(2), 36) / 100]));
    }
    data.words.grammar.split(' ').forEach(name => grammar.add(name));
  }

  // ---- words that are known and not listed: a Bloom filter (packWordFilter() in words/)
  const bits = Uint8Array.from(atob(data.words && data.words.known || ''), c => c.charCodeAt(0));
  const hash = (word, basis) => [...word].reduce((h, c) => Math.imul(h ^ c.codePointAt(0), 16777619), basis) >>> 0;
  function isKnown(word) {
    const a = hash(word, 2166136261), b = hash(word, 40389);
    return bits.length > 0 && [0, 1, 2, 3, 4, 5, 6].every(i => {
      const at = (a + i * b) % (8 * bits.length);
      return bits[at >> 3] >> (at & 7) & 1;
    });
  }

  // ---- a word as it is, or what it is a form of (morphy(7WN))
  const endings = [['s', ''], ['ses', 's'], ['xes', 'x'], ['zes', 'z'], ['ches', 'ch'], ['shes', 'sh'], ['men', 'man'],
    ['ies', 'y'], ['es', 'e'], ['es', ''], ['ed', 'e'], ['ed', ''], ['ing', 'e'], ['ing', ''],
    ['er', ''], ['est', ''], ['er', 'e'], ['est', 'e']];
  function baseOf(word, has = one => known.has(one)) {
    if (has(word)) return word;
    const bare = word.replace(/'s$/, '');
    if (has(bare)) return bare;
    if (word.endsWith('ss')) return '';
    for (const [from, to] of endings) {
      if (!word.endsWith(from) || word.length < from.length + 2) continue;
      const stem = word.slice(0, word.length - from.length);
      if (has(stem + to)) return stem + to;
      if (!to && /(.)\1$/.test(stem) && has(stem.slice(0, -1))) return stem.slice(0, -1);
    }
    return '';
  }

  // ---- near spellings: restricted Damerau–Levenshtein distance, a letter doubled counts half
  function distance(a, b) {
    const gap = (text, i) => i > 1 && text[i - 1] === text[i - 2] ? 0.5 : 1;
    const rows = [[0]];
    for (let j = 1; j <= b.length; ++j) rows[0].push(rows[0][j - 1] + gap(b, j));
    for (let i = 1; i <= a.length; ++i) {
      const row = [rows[i - 1][0] + gap(a, i)];
      for (let j = 1; j <= b.length; ++j) {
        row.push(Math.min(rows[i - 1][j] + gap(a, i), row[j - 1] + gap(b, j), rows[i - 1][j - 1] + (a[i - 1] !== b[j - 1])));
        if (i > 1 && j > 1 && a[i - 1] === b[j - 2] && a[i - 2] === b[j - 1]) row[j] = Math.min(row[j], rows[i - 2][j - 2] + 1);
      }
      rows.push(row);
    }
    return rows[a.length][b.length];
  }
  function spelledNearly(word) {
    if (word.length < 3 || word.length > 24) return '';
    const limit = Math.min(2, Math.max(1, word.length / 4));
    let best = '', lowest = Infinity;
    known.forEach((labels, candidate) => {
      if (candidate.length < 3 || Math.abs(candidate.length - word.length) > 2) return;
      const edits = distance(word, candidate);
      if (edits > limit) return;
      // what is on the map is what is mostly asked for, and the first letter is seldom wrong
      const cost = edits + (candidate[0] === word[0] ? 0 : 0.5) + (labels.length ? 0 : 0.6) + (candidate.includes(' ') ? 0.3 : 0);
      if (cost < lowest) [best, lowest] = [candidate, cost];
    });
    return best;
  }

  // "cell phone", or what is known as one word: "tooth brush"
  function togetherOf(first, second) {
    if (grammar.has(first)) return '';
    const apart = baseOf(`${first} ${second}`), isOne = second.length > 1 && first.length > 1 && !grammar.has(second);
    return apart || !isOne || !known.has(first + second) ? apart : first + second;
  }

  // ---- the words of a text that carry meaning, two together where they are known so
  function termsOf(text) {
    const words = split(text.slice(0, 400)).slice(0, 20), terms = [];
    let corrected = false, unlisted = false;
    for (let i = 0; i < words.length; ++i) {
      const two = i + 1 < words.length && togetherOf(words[i], words[i + 1]);
      if (two) { terms.push(two); ++i; continue; }
      if (grammar.has(words[i]) || words[i].length < 2) continue;
      const base = baseOf(words[i]), isOther = !base && baseOf(words[i], isKnown) !== '';
      const near = base || (isOther ? '' : spelledNearly(words[i]));
      if (near) terms.push(near);
      corrected = corrected || near !== base;
      unlisted = unlisted || isOther;
    }
    return {terms: [...new Set(terms)].slice(0, 6), corrected, unlisted};
  }

  const logit = p => Math.log(Math.min(p, 0.99) / (1 - Math.min(p, 0.99)));
  // of several words each counts the same: the mean of their log odds
  function combined(terms) {
    if (terms.length === 1) return known.get(terms[0]);  // none far from the best is in the list
    const lists = terms.map(term => new Map(known.get(term)));
    const labels = [...new Set(lists.flatMap(list => [...list.keys()]))].map(label => {
      const mean = lists.reduce((sum, list) => sum + logit(list.get(label) || otherwise), 0) / lists.length;
      return [label, 1 / (1 + Math.exp(-mean))];
    }).sort((a, b) => b[1] - a[1] || a[0] - b[0]);
    return labels.filter(([, p]) => p >= Math.max(shareOfSeveral * least, nearTheBest * labels[0][1]));
  }

  // labels: [[label, probability], …]; corrected: the words that were read where some were misspelled, else '';
  // known: whether any word is
  function understand(text) {
    if (!known.size) return {labels: [], corrected: '', known: false};
    const {terms, corrected, unlisted} = termsOf(text), telling = terms.filter(term => known.get(term).length);
    let labels = terms.length ? combined(terms) : [];
    if (!labels.length && telling.length) labels = combined(telling);
    return {labels, corrected: corrected ? terms.join(' ') : '', known: terms.length > 0 || unlisted};
  }
  return {understand, plain, least};
})();
