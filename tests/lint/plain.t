#!/usr/bin/perl
# Texts that people read are plain English: none has one of these phrases, which nobody says aloud. And what is written in
# two places by hand is the same in both: the version, the order of rooms, libraries and their doors, names of problems.
use strict;
use warnings;
use Test::More;

# A phrase, and what to write instead.
my %better = (
    'told|tells' => 'reports, shows, says', 'asked for|asks for|is asked|are asked' => 'requested', 'whose' => 'of which, or two sentences',
    'whoever|whatever|whatsoever' => 'points that, any', 'nobody|somebody' => 'no client, another client',
    'what (?:[\w-]+ ){1,3}(?:is|are|was|were)\b(?! wrong)' => 'the noun that is meant', 'such [\w -]{1,40} that' => 'so ... that, a ... that',
    '(?<!there )is no (?!longer)[a-z]+' => 'is not a', 'those of them|of them that' => 'repeat the noun',
    'goes on|go on|going down' => 'continues, shutting down', 'taken for|comes of it|comes of the|comes to be' => 'counts as, results',
    'as many as may|than it may|it may have' => 'the limit, than allowed', 'not given:' => 'Default:', 'for want of' => 'because',
    'beforehand|thereof|herein|anew|hither|thence' => 'simpler', 'at a time that' => 'when', 'nonsense' => 'invalid',
    'stands? in for|stands for|stands in (?:the|a)\b' => 'replaces, is in', 'made of the' => 'made from', 'what came|what comes' => 'the noun',
    '(?:jobs?|runs?|it|they|what) (?:is|are) over' => 'has ended', 'under way' => 'in progress', 'left alone|be left' => 'unchanged', 'alike' => 'equally, similar',
);
# The string literals of a source, adjacent ones joined; of scripts also those in single and backward quotes.
sub literals {
    my ($path, $text) = @_;
    my $comment = qr{/\*.*?\*/|(?<!:)//[^\n]*}s;
    my $quoted = $path =~ /\.js$/ ? qr/"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'|`(?:[^`\\]|\\.)*`/ : qr/"(?:[^"\\\n]|\\.)*"/;
    $text =~ s/\\\n/ \n/g;
    my @found;
    my $next = 0;
    while ($text =~ /$comment|'(?:[^'\\\n]|\\.)'|($quoted)/g) {
        my ($literal, $begin) = ($1, $-[0]);
        next if !defined $literal;
        my $line = 1 + (substr($text, 0, $begin) =~ tr/\n//);
        if (@found && substr($text, $next, $begin - $next) =~ /^\s*$/) { $found[-1][1] .= substr $literal, 1, -1 }
        else { push @found, [$line, substr $literal, 1, -1] }
        $next = $begin + length $literal;
    }
    return grep { $_->[1] =~ /[a-z]+ [a-z]+ / } @found;
}

# Paragraphs of a document, without code; a table's rows and the texts of a YAML file are lines.
sub paragraphs {
    my ($path, $text) = @_;
    $text =~ s/^```.*?^```$/ "\n" x (($& =~ tr{\n}{}) + 1) /gmse;
    $text =~ s/`[^`\n]*`/`code`/g;
    my $line = 1;
    return map { my $at = $line; $line += tr/\n//; [$at, s/\s+/ /gr] } split /(?<=\n)(?=\n|\||- |#|\s+[\w'"\$-]+:)/, $text;
}

sub slurp { my ($path) = @_; open my $in, '<', $path or die "$path: $!\n"; local $/; return <$in> }

sub faults {
    my ($path, $text) = @_;
    my @texts = $path =~ /\.(?:[ch]|cc|js)$/ ? literals($path, $text) : paragraphs($path, $text);
    return map { my ($line, $said) = @$_;
        map { $said =~ /\b($_)/i ? "$path:$line: \"$1\" (better: $better{$_}) in: " . substr($said, 0, 150) : () } sort keys %better
    } @texts;
}

my @files = grep { -f } split /\n/, `git ls-files -co --exclude-standard core proto server README.md ARCHITECTURE.md CHANGELOG.md openapi.yaml`;
my @read = grep { /\.(?:[ch]|cc|js|md|yaml|html|txt)$/ } @files;
cmp_ok scalar @read, '>', 100, 'there are texts to read';
is join("\n", map { faults($_, slurp($_)) } @read), '', 'every text is plain English';
is scalar(faults(@$_)), 1, "$_->[0] with such a phrase is seen" for ['x.md', "# A\n\nIt is told by the\ndaemon.\n"],
    ['x.c', "f(\"the key is \"\n  \"no number\");"], ['x.js', "say('the job goes on now');"];

my ($version) = slurp('Makefile') =~ /^VERSION := (\S+)$/m;
my %of = ('openapi.yaml' => qr/^  version: (\S+)$/m, 'CHANGELOG.md' => qr/^## (\d\S*)/m, 'docker/Dockerfile' => qr/^ARG VERSION=(\S+)$/m);
is +(slurp($_) =~ $of{$_})[0], $version, "$_ has the version of the Makefile" for sort keys %of;

my ($law, $text) = map { slurp($_) =~ s/\n +/ /gr } 'tests/lint/layers.t', 'ARCHITECTURE.md';
for my $part ('core', 'server') {
    my $order = join ' ', ($law =~ /^my \@$part = \((.*?)\);/m)[0] =~ /[\w ]+(?=')/g;
    is join(' ', ($text =~ /^- $part: (.*)$/m)[0] =~ /\w+/g), $order =~ s/\s+/ /gr, "ARCHITECTURE.md has the order of rooms of $part";
}
my @doors = map { s/\\//gr =~ s/\$$//r } $law =~ /qr\{\^((?:core|proto|server)\/[^}]+)\}[,\]]/g;
is_deeply [grep { index($text, "`$_`") < 0 } @doors], [], 'and every door';
my @libraries = map { s/^lib//r } split ' ', (slurp('Makefile') =~ /^PKGS := (.*)$/m)[0];
is_deeply [grep { $text !~ /$_/i } @libraries], [], 'and every library';
my %problem = map { $_ => 1 } map { slurp($_) =~ /"([a-z]+(?:-[a-z]+)+)"/g } qw(core/base/status.h server/api/problem.h);
is_deeply [grep { !$problem{$_} } slurp('openapi.yaml') =~ /\(([a-wyz]\w+-[a-z-]+)[),;]/g], [], 'openapi.yaml names problems that exist';
done_testing;
