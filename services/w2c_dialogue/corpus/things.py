"""Names of things, written for this corpus. Lists are strings, one name between commas."""


def names(text: str, separator: str = ",") -> tuple[str, ...]:
    """Split a list of names."""
    return tuple(" ".join(name.split()) for name in text.split(separator) if name.strip())


def meanings(text: str) -> tuple[tuple[str, str], ...]:
    """Split `1: x, y | 2: z` into (("x", "1"), ("y", "1"), ("z", "2"))."""
    rows = [row.split(":") for row in text.split("|")]
    return tuple((words, meaning.strip()) for meaning, listed in rows for words in names(listed))


SURFACES = names("""
table, desk, workbench, bench, shelf, counter, countertop, worktop, kitchen counter, table top,
tabletop, coffee table, dining table, side table, nightstand, dresser, drawer, cabinet, cupboard,
wardrobe, sideboard, bookcase, bookshelf, rack, chair, armchair, office chair, wooden stool,
stool, bar stool, sofa, couch, ottoman, footstool, bed, mattress, cushion, pillow, windowsill,
window sill, wall, pillar, column, post, railing, handrail, banister, guard rail, fence, gate,
door, door frame, doorknob, door handle, fridge, refrigerator, freezer, oven, stove, dishwasher,
washing machine, dryer, microwave, radiator, heater, fireplace, mantelpiece, ledge, step,
staircase, stair, stairs, ladder, rung, platform, podium, lectern, pedestal, crate, box, wooden
box, cardboard box, container, chest, trunk, toolbox, tool chest, suitcase, cart, trolley,
wheelbarrow, pallet, barrel, drum, tank, pipe, beam, plank, board, whiteboard, blackboard, panel,
slab, block, concrete block, brick, cinder block, stone, rock, boulder, log, tree trunk, tree,
stump, car, hood, bonnet, roof, tailgate, truck bed, bumper, piano, speaker, printer, photocopier,
server rack, machine, lathe, drill press, conveyor, conveyor belt, vending machine, counter top,
sink, bathtub, toilet seat, washbasin, mat, rug, carpet, towel, cloth, blanket, tablecloth, sheet,
tarp, foam block, book, dictionary, notebook, binder, folder, atlas, encyclopedia, magazine,
newspaper, stack of books, pile of papers, stack of plates, tray, chopping board, cutting board,
baking tray, plate rack, surface, ground, floor, hospital bed, wheelchair, walker, altar, pew,
picnic table, ping pong table, pool table, workstation, console, control panel, dashboard,
steering wheel, scaffold, scaffolding, hatch, bulkhead, hull, wing, crossbar, goal post, net post,
hurdle, vaulting box, yoga block, weight bench, treadmill, crash pad, aquarium, cage, kennel, dog
bed, mailbox, letterbox, lamp post, bollard, curb, kerb, manhole cover, hay bale, trough, planter,
flower bed, parapet, balustrade, balcony rail, backrest, armrest, headrest, seat, tabouret,
hassock, buffet, hutch, vanity, easel, anvil
""")

THINGS = names("""
cup, mug, glass, wine glass, tumbler, jar, jug, pitcher, carafe, bottle, water bottle, flask,
thermos, teapot, kettle, coffee pot, coffee cup, teacup, saucer, plate, dish, bowl, salad bowl,
soup plate, pan, frying pan, saucepan, pot, wok, lid, spoon, fork, knife, spatula, ladle, whisk,
tongs, rolling pin, grater, peeler, colander, sieve, funnel, corkscrew, can opener, bottle opener,
blender, toaster, mixer, coffee machine, juicer, scale, timer, oven mitt, dish towel, sponge,
scrubber, brush, dustpan, broom, mop, bucket, trash can, bin, waste basket, basket, laundry
basket, bag, paper bag, plastic bag, backpack, handbag, purse, wallet, briefcase, lunch box,
apple, banana, orange, lemon, lime, pear, peach, plum, grape, bunch of grapes, melon, watermelon,
pineapple, mango, kiwi, strawberry, tomato, potato, carrot, onion, garlic, pepper, cucumber,
lettuce, cabbage, broccoli, pumpkin, mushroom, corn cob, bread, loaf, baguette, croissant, bagel,
bun, cake, muffin, donut, pie, pizza, sandwich, burger, cookie, cookie jar, biscuit tin, cereal
box, cracker box, milk carton, juice box, egg carton, egg, cheese, butter dish, yogurt pot, sugar
bowl, salt shaker, pepper mill, spice jar, soup can, tuna can, soda can, can of beans, box of
nails, nail box, screw box, mustard bottle, ketchup bottle, pudding box, gelatin box, chips can,
coffee can, bleach bottle, hammer, mallet, screwdriver, wrench, spanner, pliers, saw, hand saw,
hacksaw, drill, power drill, cordless drill, chisel, file, clamp, vise, tape measure, ruler,
level, spirit level, square, crowbar, axe, hatchet, shovel, rake, hoe, pickaxe, sledgehammer,
soldering iron, multimeter, glue gun, stapler, staple gun, paint brush, paint can, paint roller,
ladder hook, rope, chain, cable, extension cord, power strip, plug, socket, switch, light switch,
button, red button, lever, knob, dial, valve, wheel, crank, pedal, joystick, handle, hook, hinge,
bolt, nut, screw, nail, washer, spring, gear, bearing, bracket, hose, nozzle, pen, pencil, marker,
highlighter, crayon, eraser, sharpener, scissors, tape, roll of tape, duct tape, glue stick, paper
clip, paper, envelope, letter, postcard, stamp, calculator, laptop, computer, keyboard, mouse,
mouse pad, monitor, screen, tablet, phone, cell phone, smartphone, telephone, charger, headphones,
headset, microphone, camera, tripod, projector, remote, remote control, television, tv, radio,
clock, alarm clock, watch, lamp, desk lamp, floor lamp, lantern, candle, candlestick, flashlight,
torch, light bulb, battery, fan, vase, flower pot, plant, potted plant, flower, cactus, picture,
picture frame, painting, poster, mirror, globe, trophy, statue, figurine, doll, teddy bear, toy
car, toy truck, toy robot, lego brick, puzzle, puzzle box, rubiks cube, cube, ball, tennis ball,
football, basketball, baseball, baseball bat, golf ball, racket, frisbee, dumbbell, kettlebell,
helmet, hard hat, hat, cap, scarf, glove, shoe, boot, sneaker, slipper, sock, shirt, jacket, coat,
belt, tie, umbrella, walking stick, cane, glasses, sunglasses, key, keys, bunch of keys, padlock,
coin, card, deck of cards, dice, chess piece, chessboard, board game, guitar, violin, drumstick,
trumpet, flute, harmonica, toothbrush, toothpaste, comb, hairbrush, hair dryer, soap, soap
dispenser, shampoo bottle, lotion, tissue box, toilet paper, paper towel, towel roll, medicine
bottle, pill box, first aid kit, bandage, syringe, stethoscope, fire extinguisher, smoke detector,
thermostat, doorbell, safe, cash register, barcode scanner, shopping bag, shopping basket, parcel,
package, carton, tin, tube, bottle cap, cork, straw, napkin, placemat, coaster, ice cube tray,
lunch bag, beer can, wine bottle, cocktail shaker, perfume bottle, spray bottle, detergent bottle,
oil can, gas can, fuel can, propane tank, air pump, tire, hubcap, bicycle, bike pump, scooter,
skateboard, roller skate, robot, drone, robot arm, gripper, motor, circuit board, wire spool,
sensor, antenna, traffic cone, cone, sign, stop sign, flag, whistle, megaphone, binoculars,
telescope, microscope, test tube, beaker, petri dish, pipette, seashell, pebble, stick, branch,
leaf, pine cone, bird feeder, watering can, garden gnome, wind chime, sundial, thing, object,
item, gadget, device, tool, toy, ornament, contraption, stuff, piece of wood, piece of metal, bit
of cloth, pile of clothes
""")

SIZES = names("""
big, large, huge, small, little, tiny, tall, short, long, wide, narrow, thick, thin, flat, round,
square, rectangular, oval, heavy, low, high, deep, shallow, medium, giant, mini, oversized, slim,
curved, bent, pointy, cylindrical, triangular
""")

COLOURS = names("""
red, green, blue, yellow, orange, purple, pink, brown, black, white, grey, gray, beige, turquoise,
cyan, magenta, violet, golden, gold, silver, dark blue, light blue, dark green, light green, dark
red, bright yellow, pale pink, navy, navy blue, maroon, olive, cream, off-white, transparent,
clear, colourful, colorful, striped, spotted, checkered, black and white, reddish, greenish,
bluish, dark, light, bright
""")

MATERIALS = names("""
wooden, metal, plastic, glass, steel, iron, brass, copper, aluminium, aluminum, leather, rubber,
ceramic, porcelain, stone, marble, granite, concrete, brick, paper, cardboard, cotton, woolen,
velvet, fabric, wicker, bamboo, oak, pine, foam, styrofoam, clay, chrome, stainless steel, cast
iron, canvas, denim, cork, straw, silk, linen, felt, carbon fibre, acrylic, vinyl, enamel
""")

STATES = names("""
old, new, empty, full, open, closed, broken, dirty, clean, dusty, shiny, rusty, wet, dry, soft,
hard, fancy, cheap, ugly, nice, antique, modern, folded, rolled up, upside down, half full, half
empty, sturdy, solid, wobbly, cracked, worn, smooth, rough, slippery, plain, other, same, first,
second, last, next, closest, nearest, farthest, leftmost, rightmost, topmost, middle, tilted,
spare
""")

PARTS = names("""
handle, lid, cap, spout, neck, base, rim, edge, corner, surface, top, back, front, side, leg, arm,
armrest, backrest, seat, cover, label, knob, button, drawer, door, hinge, frame, shelf, shelves,
stripe, stripes, dots, logo, sticker, wheel, wheels, screen, keyboard, strap, string, cord, cable,
plug, blade, tip, head, bristles, pages, spine, flowers, leaves, pattern, picture, letters, hole,
holes, foot, feet, ears, eyes, tail, light, antenna, switch, dial, hook, ring, chain, pocket,
zipper, laces, sleeves, collar
""")

THING_WORDS = names("""
thing, object, one, item, stuff, thingy, gizmo, container, box, tool, gadget, piece, bit, part,
surface, device
""")

PURPOSES = names("""
you drink from, to drink from, you sit on, people sit on, used for hammering, for cutting bread,
that holds the flowers, that looks like a box, that keeps food cold, that shows the time, for
holding water, full of water, full of coffee, full of nails, filled with sand, covered in dust,
covered with paint, made of wood, made of metal, made of glass, made of stone, for writing, to
write with, you read, for paper, that is broken, that is open, that is lying down, that fell over,
shaped like a cube, shaped like a ball, that glows, that makes coffee, for tools, with nothing on
it, that looks soft, that looks sturdy
""")

PLACES = names("""
on the table, on the shelf, on the floor, in front of you, over there, near the wall, by the
window, on top of the fridge, in the picture, on the desk, that you see, you can see, on the
counter, on the workbench, on the ground, in this room, here, on the cabinet
""")
"""Where a thing stands: said beside its name, no part of it."""

WHICH = names("""
on the left, on the right, in the corner, in the back, in the middle, behind the others, at the
back, to your left, to your right, closest to you, farthest away, nearest to you, furthest from
you, in the front, in the front row, on your left, on your right, at the top, at the bottom, at the
very end, that is on the left, that's on the right, which is closer, that is farther away
""")
"""Which one of several: a part of its name."""

NEAR = names("""
next to, next to, beside, behind, in front of, near, by, on top of, under, above, below, left of, to
the left of, right of, to the right of, inside, in, against, opposite, close to, on
""")
"""Which one of several, by another thing."""

SYLLABLES = names("""
ka, lo, mi, zen, tor, pel, vi, qua, dro, bri, sa, nu, fex, gli, jo, ran, ti, mo, chi, whe, stra,
ble, ox, ix, um, ar, el, za, pop, nut, choc, cris, fla, do, ga, hy, ju, lu, ner, py, rex, sno,
tup, ver, wib, yo
""")
"""Brands and words nobody has heard: the model must point at what it does not know."""
