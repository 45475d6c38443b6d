#!/usr/bin/perl
# The product knows nothing of the toy: what config=toy adds, it adds by rows in a header of its own.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin, "$FindBin::Bin/../cli";
use Toy;
use Cli;
use Test::More;

my $header = slurp('tests/support/toy/toy.h');
$header =~ s/\\\n/ /g;

# The rows of each list: identifier and name, in quotes or without.
my (%id, %name);
my %kind = (RUN_STAGES => 'RUN_STAGE', STOPPED => 'STOPPED', GROUPS => 'GROUP', METHOD_CHOICES => 'METHOD', PARAMETERS => 'PARAM');
while ($header =~ /^#define VOR_EXTRA_(\w+)\(X\)(.*)$/mg) {
    my ($list, $rows) = ($1, $2);
    while ($rows =~ /\bX\((?:([A-Z_]+), )?"?([a-z]+)?/g) {
        $id{"VOR_$kind{$list}_$1"} = 1 if defined $1 && $kind{$list};
        $name{$2} = 1 if defined $2 && $list ne 'METHODS' && $list ne 'RUNNERS';
    }
}
is scalar(keys %id), 6 + 1 + 5 + 1 + 10, 'stages, reasons, groups, methods and parameters are read';
is_deeply [grep { !$name{$_} } qw(toy census overlap excerpt copy prove copied parts pause remark)], [], 'and their names';

my @sources = grep { -f } split /\n/, `git ls-files -co --exclude-standard core proto server openapi.yaml docker`;
cmp_ok scalar(@sources), '>', 100, 'there is a product to look at';
my ($ids, $names) = (join('|', sort keys %id), join('|', sort keys %name));
my $theirs = qr/\b(?:$ids)\b|\b(?:vor_)?toy(?:s\b|_|\b)|"(?:$names)"/i;
like $_, $theirs, "$_ would be seen"
    for 'spec->value[VOR_PARAM_PARTS]', 'strcmp(id, "census")', 'case VOR_RUN_STAGE_COPY:', '#include "tests/support/toy/toy.h"',
    'vor_toy_run';
my @mentions;
for my $file (@sources) {
    my $line = 0;
    for (split /\n/, slurp($file)) {
        $line++;
        push @mentions, "$file:$line: $&" if $_ =~ $theirs;
    }
}
is join("\n", @mentions), '', 'no file of the product mentions what the toy adds';

# Nor does its binary.
ok -x $Toy::product, 'there is one';
my $help = `$Toy::product --help`;
like $help, qr/^  resample /m, 'it lists its processes';
unlike $help, qr/^  (?:excerpt|census|overlap) /m, 'and none of the toy';
unlike scalar `$Toy::product resample --help`, qr/\btoy\b|--parts\b/, 'nor has resample the method';
like scalar(`$Toy::product census x.ply 2>&1`), qr/\Avoronoid: census: no such command; /, 'nor is there its command';
done_testing;
