#!/usr/bin/perl
# Forms and gzip bodies with bytes changed, cut, doubled and put in: each is answered, none by a 5xx, and the daemon stays
# as it was. 60 of each here, 10,000 in make soak.
use strict;
use warnings;
use FindBin;
use IO::Compress::Gzip qw(gzip);
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $bodies = $ENV{VT_SOAK} ? 10_000 : 60;
my $rss_most = 64 << 10; # KiB above the same bodies unchanged
my $cloud = sphere_ply(60);
my @query = ('iterations' => 0, 'polish' => 0);
my $text = join '', map { "--bnd\r\nContent-Disposition: form-data; name=\"$_->[0]\"\r\n\r\n$_->[1]\r\n" } ['iterations', 0], ['polish', 0];
my $points = "--bnd\r\nContent-Disposition: form-data; name=points\r\n\r\n20\r\n";
my $file = "--bnd\r\nContent-Disposition: form-data; name=\"file\"; filename=\"x.ply\"\r\nContent-Type: application/octet-stream\r\n\r\n$cloud\r\n";
my $reference = $file =~ s/"file"/"reference"/r;
my @forms = map { "$_--bnd--\r\n" } "$text$points$file", "$file$text$points", "$points$file$text";
my @pairs = map { "$_--bnd--\r\n" } "$file$reference", "$reference$file";
my @packed = map { my ($bytes, $level) = @$_; gzip(\$bytes, \my $out, -Level => $level, -Time => 0); $out } [$cloud, 6], [$cloud, 0], [$cloud, 9];
my $run = '/v1/resample?points=20&iterations=0&polish=0';
my $form = 'multipart/form-data; boundary=bnd';
my %kinds = (
    multipart => [
        (map { ['/v1/resample', { 'Content-Type' => $form }, $_] } @forms),
        (map { ['/v1/measure', { 'Content-Type' => $form }, $_] } @pairs),
    ],
    gzip => [map { [$run, { 'Content-Encoding' => 'gzip' }, $_] } @packed],
);

# What is put in is often what a scanner looks for.
my @bits = ("\r\n", "\r", "\n", '--', '--bnd', "\r\n--bnd", "\r\n--bnd--\r\n", '"', ';', '=', ':', "\0", "\xff", 'name=', '\\',
    "\x1f\x8b\x08", 'x' x 5000);
sub mutant { return Vt::mutant($_[0], 400, @bits) }

# Sends it in one piece, which does not wait for a delayed ACK, on a connection of its own.
sub answer {
    my ($daemon, $path, $headers, $body) = @_;
    my $head = join '', map { "$_: $headers->{$_}\r\n" } sort keys %$headers;
    my $text = $daemon->raw("POST $path HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n${head}Content-Length: "
        . length($body) . "\r\n\r\n$body");
    return { status => $text =~ m{\AHTTP/1\.1 (\d+)} ? $1 : 0, text => $text };
}

sub rss {
    my ($daemon) = @_;
    return Vt::slurp("/proc/$daemon->{pid}/status") =~ /^VmRSS:\s+(\d+)/m ? $1 : 0;
}

for my $kind (sort keys %kinds) {
    my $daemon = Vt->start('body-limit' => '1M', 'result-ttl' => 1);
    my (%most, %count, @wrong);
    srand 14;
    for my $is_mutant (0, 1) {
        for my $i (1 .. $bodies) {
            my ($path, $headers, $bytes) = @{ $kinds{$kind}[rand @{ $kinds{$kind} }] };
            my $answer = answer($daemon, $path, $headers, $is_mutant ? mutant($bytes) : $bytes);
            $count{$is_mutant}{ $answer->{status} }++;
            push @wrong, "$answer->{status} $answer->{text}"
                if $answer->{status} !~ /^[24]/ || !$is_mutant && $answer->{status} != 200
                || $answer->{status} >= 400 && $answer->{text} !~ m{^Content-Type: application/problem\+json\r$}m;
            my $now = $i % 50 == 0 || $i == $bodies ? rss($daemon) : 0;
            $most{$is_mutant} = $now if $now > ($most{$is_mutant} // 0);
        }
    }
    is "@wrong[0 .. ($#wrong > 2 ? 2 : $#wrong)]", '', "$kind: every body is answered, none by a 5xx";
    cmp_ok scalar(keys %{ $count{1} }), '>', 1, "$kind: some are taken, some are refused";
    cmp_ok $most{1} - $most{0}, '<=', $rss_most, "$kind: memory stays as it was";
    diag "$kind: ", join(', ', map { "$count{1}{$_} of $_" } sort keys %{ $count{1} }), "; at most $most{1} KiB resident, $most{0} unchanged"
        if $ENV{VT_SOAK};
    is scalar(grep { $_->{msg} eq 'listening' } $daemon->log_lines), 1, "$kind: it never started again";
    is scalar(() = glob "$daemon->{dir}/data/blobs/tmp/*"), 0, "$kind: nothing is left half-way";
    is $daemon->stop, 0, "$kind: it ends with 0";
}
done_testing;
