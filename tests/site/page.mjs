// SPDX-License-Identifier: Apache-2.0
// A browser on the live page; browser.cpp runs it: node page.mjs MODULES URL WIDTH KIND FOLDER
// KIND: "live", on a view that the test changes by hand; "at rest", on a map file.
// FOLDER: where to put screenshots; none without it.
import {createRequire} from 'node:module';
const [modules, url, width, kind, folder] = process.argv.slice(2);
const puppeteer = createRequire(`${modules}/package.json`)('puppeteer-core');
// A start takes half a second where nothing else runs; beside other work its files may take half a minute to read.
const browser = await puppeteer.launch({executablePath: '/usr/bin/chromium', timeout: 180000, protocolTimeout: 600000, args: ['--headless=new', '--no-sandbox', '--disable-dev-shm-usage']});
const problems = [];

function expect(isTrue, what) {
  if (!isTrue) problems.push(what);
}

const page = await browser.newPage();
page.setDefaultTimeout(300000);  // the thread sanitizer makes all twenty times slower
let isWatched = true;
page.on('console', message => expect(!isWatched || message.type() !== 'error', `console: ${message.text()} ${message.location().url}`));
page.on('pageerror', error => problems.push(`error: ${error.message}`));
page.on('request', request => expect(request.url().startsWith(url) || request.url().startsWith('data:'), `asks ${request.url()}`));
await page.setViewport({width: +width, height: 844});
await page.emulateMediaFeatures([{name: 'prefers-reduced-motion', value: 'reduce'}]);

const textOf = selector => page.$eval(selector, element => element.textContent);
const count = selector => page.$$eval(selector, elements => elements.length);
const waitForText = (selector, text) => page.waitForFunction((s, t) => {
  const element = document.querySelector(s);
  return element && element.textContent.includes(t);
}, {}, selector, text);
const waitForCount = (selector, n) => page.waitForFunction((s, n) => document.querySelectorAll(s).length === n, {polling: 50}, selector, n);
const press = async (selector, key = 'Enter') => {
  await page.$eval(selector, element => element.focus());  // focus() of puppeteer knows no SVG
  await page.keyboard.press(key);
};
const pressButton = text => page.evaluate(t => [...document.querySelectorAll('#found button')].find(b => b.textContent === t).click(), text);
const shoot = async name => folder && await page.screenshot({path: `${folder}/${kind.replace(' ', '-')}-${name}-${width}.png`, fullPage: true});
async function fitsItsWidth(when) {
  const [wide, window] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  expect(wide <= window, `${when} it is ${wide} of ${window} pixels wide`);
}
async function open() {
  await page.goto(url, {waitUntil: 'domcontentloaded'});
  await page.waitForSelector('#plan [data-kind=area]');
}

async function rename(area, name) {
  for (let tries = 1; !await page.$('.rename input'); ++tries) {  // a map that grows may be drawn anew meanwhile
    await press(`#plan [data-kind=area][data-id="${area}"]`);
    await page.waitForSelector('.rename input', {timeout: 5000}).catch(error => { if (tries === 10) throw error; });
  }
  await page.$eval('.rename input', input => { input.value = ''; });
  await page.type('.rename input', name);
  await page.keyboard.press('Enter');
  await waitForText('#areas', name);
  await waitForText('#found', `It is called “${name}” from now on`);
  await shoot('renamed');
  await open();
  await waitForText('#areas', name);
  await page.waitForFunction(n => [...document.querySelectorAll('#plan [data-kind=area] title')].some(title => title.textContent.includes(n)), {}, name);
}

async function search(words) {
  await page.keyboard.press('/');
  await page.$eval('#word', input => { input.value = ''; });
  await page.type('#word', words);
  await page.keyboard.press('Enter');
  await waitForText('#found h2', `“${words}”`);
}

async function askFor(words) {
  await search(words);
  await page.waitForSelector('#plan .way .over');
  await page.waitForFunction(() => /^(From place \d+ drive|Place \d+ is there already)/.test(document.querySelector('#found .go')?.textContent));
  await fitsItsWidth(`with answers to ${words}`);
}

async function ask() {
  await askFor('umbrella');
  expect((await textOf('#found .items')).includes('umbrella'), 'the umbrella is among the answers');
  expect(await count('#plan [data-kind=object][data-id="3"].on') === 1, 'the umbrella is highlighted on the map');
  await shoot('asked');
  await page.type('#word', ' xqzzkw');
  await page.$eval('#word', input => { input.value = 'xqzzkw'; });
  await press('#word');
  await waitForText('#found', 'Nothing on the map means that');
  await page.keyboard.press('Escape');
  expect(await textOf('#found') === '', 'Escape closes the panel');
}

async function watch() {
  await waitForText('#where-name', 'kitchen');
  await page.waitForFunction(() => document.getElementById('frame').naturalWidth > 0 && !document.getElementById('frame').hidden);
  expect(await textOf('#decision') !== '', 'the decision is explained');
  expect((await textOf('#now-words')).includes('<b>cup</b>') && await count('#now-words b') === 0, 'names are text');
  expect((await textOf('#alerts')).includes('no frame <for> 3 s'), 'troubles are shown');
  expect(await count('#plan .robot') > 0 && await count('#plan .belief circle') === 2, 'robot and belief are on the map');
  await shoot('watched');
  await waitForCount('#plan [data-kind=object]', 5);  // the map grows
  await waitForCount('#plan [data-kind=object]', 6);
}

async function seeChanges() {
  await page.click('#changes');
  await waitForText('#found', 'Since drive 1 began');
  const items = await textOf('#found .items');
  for (const change of ['Moved: coffee mug', 'New: part of coffee mug', 'Gone: something', 'Place 2 looks different', 'umbrella 10 % → 60 %'])
    expect(items.includes(change), `the changes have “${change}”: ${items}`);
  await fitsItsWidth('with changes');
  await shoot('changed');
  await page.click('#found .item');
  expect(await count('#plan [data-kind=object][data-id="1"].on') === 1, 'what was moved is highlighted on the map');
  await page.keyboard.press('Escape');
}

async function correct() {
  await press('#plan [data-kind=object][data-id="1"]');
  await waitForText('#found h2', 'coffee mug');
  await pressButton('Delete');
  await pressButton('Really delete?');
  await page.waitForFunction(() => document.getElementById('found').textContent === '');
  await press('#plan [data-kind=area][data-id="0"]');
  await pressButton('Merge with …');
  await shoot('merging');
  await pressButton('corridor');
  await page.waitForFunction(() => document.getElementById('found').textContent === '');
  await press('#plan [data-kind=area][data-id="3"]');
  await pressButton('Split');
  const box = await (await page.$('#plan [data-kind=area][data-id="3"] path')).boundingBox();
  await page.mouse.click(box.x + box.width * 0.25, box.y + box.height / 2);
  await page.mouse.click(box.x + box.width * 0.75, box.y + box.height / 2);
  await shoot('splitting');
  await press('#found .ends + .actions button');
  await page.waitForFunction(() => document.getElementById('found').textContent === '');
  await press('#plan [data-kind=place][data-id="3"]');
  await waitForText('#found', 'Seen there');
  await fitsItsWidth('with a place');
}

async function loseConnection() {
  isWatched = false;  // the browser itself tells of a server that is gone
  await page.evaluate(() => fetch('/api/edits', {method: 'POST', headers: {'Content-Type': 'application/json'},
    body: JSON.stringify({type: 'name_area', area: 1, name: 'restart'})}));
  await waitForText('#alerts', 'connection is lost');
  await waitForText('#alerts', 'Connected again');
}

async function visitSampleWorld() {
  expect(await count('#plan [data-kind=area]') === 4, 'four areas');
  await fitsItsWidth('at first');
  if (kind === 'live') {
    await watch();
    await seeChanges();
  }
  else await waitForText('#state', 'Map at rest');
  await ask();
  await rename(1, 'Spa & "Sauna" <i>');
  expect(await count('#areas i:not(.tint)') === 0, 'a name is no markup');
  if (kind === 'live') {
    await correct();
    await loseConnection();
  }
}

try {
  await open();
  await visitSampleWorld();
} catch (error) {
  problems.push(`${error.message} (${error.stack.split('\n').filter(line => line.includes('page.mjs')).join(' ')})`);
  await shoot('failed').catch(() => {});
}
await browser.close();
if (problems.length) {
  console.log(problems.join('\n'));
  process.exit(1);
}
