"""Rarer things, words to build names of things from, and sounds to build words from.

A model that has seen a thousand nouns learns the nouns; one that has seen a hundred thousand names
learns where names stand. Lists are strings, as in `things`.
"""

from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.things import names

RARER = names("""
abacus, accordion, adapter, adhesive roll, alembic, allen key, amplifier, apron, ashtray, awning,
baby monitor, bain-marie, banjo, barbell, barometer, bassinet, baton, bell, bellows, bidet,
billhook, binder clip, birdcage, bird house, biscuit, blotter, bobbin, bolster, bongo, bonsai,
boot scraper, boule, bow tie, bracelet, bread bin, breaker panel, brooch, bubble wrap, buckle,
bulletin board, bunk, bust, cafetiere, cake stand, caliper, camp stove, canister, carabiner, card
reader, cashbox, casserole, castanets, caster, catheter tray, ceiling fan, cello, centrifuge,
chaise, chalice, chalk, chandelier, cherry picker, chest freezer, china cabinet, choker, cigar
box, clipboard, clothes peg, clothes rack, coat hanger, coat stand, cocktail stick, colony
counter, compass, compost heap, concertina, cookbook, cooler, coping saw, cot, counterweight,
crayfish pot, credenza, crib, crochet hook, croquet hoop, crowd barrier, crucible, crutch, cuckoo
clock, cuff link, curling iron, curtain rail, dartboard, decanter, deck chair, defibrillator, desk
organiser, desiccator, diffuser, digger, dinghy, diode, dish drainer, display case, distillation
column, diving mask, docking station, document tray, doormat, dovetail jig, dowel, drafting table,
drain, draughts board, drawbar, drip stand, drum kit, dumbwaiter, earmuffs, earring, earthenware
pot, edging spade, egg timer, egg whisk, endoscope, engine block, epaulette, espresso cup,
evaporator, eyebolt, face mask, faucet, feather, feather duster, fencing foil, fern, ferrule,
fiddle, filing cabinet, fish tank, flagpole, flail, flan, flip chart, floodlight, floppy disk,
fob, foghorn, foil tray, fondue set, food processor, footrest, forceps, fork lift, fountain,
fountain pen, fruit bowl, fume hood, fuse box, gangway, garden bench, garden fork, gargoyle,
garment bag, gas burner, gauntlet, gauze, gavel, gazebo, gear stick, glockenspiel, glove box,
goblet, goggles, gong, grandfather clock, gravy boat, griddle, grindstone, grommet, guillotine,
gumboot, gyroscope, halter, hammock, hamper, hand truck, hand weight, hardback, harness, hat
stand, headlamp, hearth, hedge trimmer, hod, holster, hourglass, ice axe, ice bucket, icon,
incense burner, incubator, ink bottle, inkwell, ironing board, ivy, jackplane, jam jar, javelin,
jerrycan, jewellery box, jigsaw, joist, jump rope, junction box, kayak, keg, kiln, kimono,
knapsack, kneeler, knitting needle, lacquer box, ladle rest, lampshade, lasagne dish, lathe chuck,
lawnmower, leash, ledger, lens cap, light table, linen chest, litter tray, locker, log basket,
loom, loudspeaker, lunch tray, lute, magnet, magnifying glass, mandolin, manikin, manometer,
maraca, marble run, mash tun, mask, measuring cup, measuring jug, meat tenderiser, medal,
metronome, milk churn, milk frother, mincer, mitre saw, mooring post, mortar, mousetrap, muffler,
music stand, muzzle, nail clippers, nail gun, napkin ring, net, newel post, newsstand, night
light, notice board, nutcracker, oar, oboe, oil drum, oil lamp, omelette, orchid, oscilloscope,
outlet, oxygen bottle, oyster, paddle, paint pot, paintbrush, palette, palette knife, pallet jack,
pannier, paperback, paper shredder, paperweight, parasol, parking meter, pasta maker, patchwork
quilt, peg board, pencil case, pendulum, pepper spray, perch, pestle, petrol pump, pew cushion,
photo album, piano stool, piggy bank, pigeonhole, pill bottle, pillowcase, pin cushion, pinball
machine, pipe wrench, piston, pitchfork, plane, plant pot, plaster cast, plate warmer, playing
card, plinth, plough, plumb line, plunger, pocket knife, poker, pole, pommel horse, porthole,
portfolio, post box, potato masher, potter's wheel, powder puff, pram, press, pressure cooker,
price tag, printing press, prism, propeller, pruning shears, pulley, pulpit, pump, punch bag,
punnet, puppet, push chair, quill, quilt, quiver, radar, rail, rain gauge, ramekin, ratchet,
rattle, razor, reading lamp, receipt, record player, recycling bin, reel, reflector, regulator,
retort stand, revolving door, ribbon, rice cooker, ring binder, riveter, road sign, rocking chair,
rocking horse, roof rack, rosary, rosette, rotor, router, rowing machine, rubber duck, rubber
stamp, rucksack, rudder, saddle, safety pin, salad spinner, sandbag, sander, sandpaper, satchel,
satellite dish, sauce boat, saxophone, scabbard, scales, scalpel, sceptre, scone, scoop,
scoreboard, scraper, screen door, scroll, sculpture, scythe, seed tray, seesaw, set square, sewing
machine, shackle, shaker, shaving brush, shawl, sheath, shield, shin pad, shoe horn, shoe rack,
shoebox, shower head, shutter, sickle, sideboard clock, sink plunger, skewer, skittle, sled,
sleeping bag, slide rule, sling, smock, snare drum, snorkel, snow globe, snowboard, soap bar, soda
siphon, solar panel, soup tureen, space heater, spanner set, spindle, spinning wheel, spirit lamp,
spoke, spotlight, spreader, sprinkler, spur, squeegee, stained glass, stake, stapler box, starting
block, steamer, stencil, stepladder, stereo, stilt, stirrer, stirrup, stockpot, stopwatch,
strainer, stretcher, string of beads, strongbox, stud finder, sugar tongs, surfboard, swab,
sweater, swing, switchboard, swivel chair, sword, tabla, table saw, tablet stand, tackle box,
tailor's dummy, tambourine, tangerine, tankard, tap, tape deck, tapestry, tarpaulin, tassel, tea
caddy, tea cosy, tea strainer, tea towel, telegraph, tent peg, terrarium, test rig, theodolite,
thermometer, thimble, throttle, tiara, tiller, tissue, toast rack, toboggan, toggle, tongue
depressor, toothpick, torque wrench, totem pole, tourniquet, towel rail, tow bar, tractor, traffic
light, trampoline, transformer, trapdoor, trellis, trestle, triangle, trivet, trombone, trowel,
tuba, tub, tuning fork, turbine, tureen, turntable, turnstile, tweezers, typewriter, ukulele,
umbrella stand, urn, vacuum cleaner, vacuum flask, valve wheel, vat, veil, ventilator, vest, vial,
violin case, visor, voltmeter, waffle iron, waistcoat, walkie-talkie, wall hook, wand, wardrobe
door, warning light, wash bag, water cooler, water pistol, wax seal, weather vane, webcam, wedge,
weighing scale, well, wetsuit, whetstone, whip, whisk broom, wicker chair, wig, winch, wind sock,
windmill, wine cooler, wine rack, wire cutter, wok lid, wood stove, woodblock, worktable, wreath,
wrist strap, xylophone, yardstick, yoke, zither
""")

KINDS = names("""
holder, rack, stand, cover, box, case, tray, lid, tin, bag, jar, hook, strap, shelf, hanger, tank,
bin, basket, bucket, drawer, cabinet, board, plate, panel, table, bench, stool, cart, post, frame,
mount, base, block, pad, mat, roll, rod, tube, pipe, valve, switch, knob, handle, lever, wheel,
key, lock, cap, cup, can, bottle, brush, knife, hammer, press, pump, filter, meter, gauge, lamp,
light, opener, cutter, cleaner, maker, warmer, sharpener, dispenser, grinder, scraper, peeler,
feeder, dryer, heater, washer, mixer, printer, reader, scanner, charger, tester, model, kit, set,
stack, pile
""")
"""Last words of names of two words."""

MATTERS = names("""
bread, butter, cheese, honey, tea, coffee, sugar, salt, fish, egg, cake, fruit, herb, wine, beer,
milk, soup, ice, water, gas, oil, paint, ink, glue, wax, soap, towel, shoe, coat, hat, glove,
belt, laundry, curtain, carpet, pillow, baby, dog, cat, bird, horse, plant, seed, garden, lawn,
leaf, tree, log, bike, car, boat, truck, wheel, tyre, engine, brake, cable, wire, fuse, battery,
phone, laptop, screen, paper, letter, card, book, photo, pen, coin, ticket, key, tool, nail, bolt,
drill, saw, sample, blood, pill, needle, wound, foot, hair, nail polish, tooth, kitchen, bathroom,
office, lab, floor, wall, roof, window, door, stair, corner, wall mounted, travel, gift, toy,
music, guitar, drum, piano, ball, golf, ski, fishing, camping, safety, fire, first aid, emergency,
spare, power
""")
"""First words of names of two words."""

ONSETS = names("""
b, c, d, f, g, h, j, k, l, m, n, p, qu, r, s, t, v, w, y, z, bl, br, ch, cl, cr, dr, fl, fr, gl,
gr, kl, kn, ph, pl, pr, sc, sh, sk, sl, sm, sn, sp, st, str, sw, th, tr, tw, wh, wr, zh
""")
VOWELS = (*"aeiou", *"aeiou", "ai", "ea", "ee", "ei", "ie", "oa", "oo", "ou", "au", "y")
CODAS = ("",) * 5 + names("""
b, d, g, l, m, n, p, r, s, t, x, k, ck, ft, ld, mp, nd, ng, nk, nt, rd, rk, rm, rn, rt, sh, sk, ss,
st, th, tz
""")
ENDINGS = (
    "",
    "",
    "",
    "er",
    "ette",
    "ing",
    "ium",
    "o",
    "a",
    "ax",
    "ix",
    "on",
    "us",
    "le",
    "y",
    "is",
)


def compound(draw: Draw) -> str:
    """Return a name of two words that says what the thing is for: `honey warmer`."""
    return f"{draw.pick(MATTERS)} {draw.pick(KINDS)}"


def sounds_like_a_word(draw: Draw) -> str:
    """Return a word nobody has heard, of sounds that words have: `strookle`."""
    syllables = (
        draw.pick(ONSETS) + draw.pick(VOWELS) + draw.pick(CODAS) for _ in range(1 + draw.below(2))
    )
    return "".join(syllables) + draw.pick(ENDINGS)
